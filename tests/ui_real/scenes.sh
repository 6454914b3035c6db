# The scenes of the pictures, sourced by shots.sh: the start page, every step of the shipped flight, then sessions whose recordings are there.
settle=4 start
shot start
stop
start sessions/demo.toml
xdotool key ctrl+8; sleep 1
shot workbench
names=(recording channels aircraft signals manoeuvres filter model)
for at in "${!names[@]}"; do
    xdotool key "ctrl+$((at + 1))"; sleep 1
    shot "${names[$at]}"
done
xdotool key ctrl+8; sleep 1
command Correlation
shot correlation
command "Noise"
shot noise
command "Compute sensitivity"; sleep "${study:-6}"
command "Sensitivity"
shot sensitivity
command "Light theme"
xdotool key ctrl+7; sleep 1
shot model_light
xdotool key ctrl+9; sleep 1
shot report_light
command "Dark theme"
stop
for session in citation_aileron attas phlab_short_period; do
    recording=$(sed -n 's/^path = "\(\.\..*\)"/\1/p' "sessions/reference/$session.toml" | head -1)
    if [ ! -e "sessions/reference/$recording" ]; then
        echo "$session: left out, there is no sessions/reference/$recording"
        continue
    fi
    start "sessions/reference/$session.toml"
    xdotool key ctrl+8; sleep 1
    shot "$session"
    stop
done
