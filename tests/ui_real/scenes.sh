# The scenes of the pictures, sourced by shots.sh: the shipped flight first, then the sessions whose recordings are there.
start
shot workbench
command Innovations
command Model
command Correlation
shot model
command "Fits and residuals"
command "Noise and filter"
command Derivatives
shot noise
command "Ground track"
command "Model"
command "Sensitivity"
command "Compute sensitivity"
sleep "${settle:-8}"
shot sensitivity
command Flight
command Propulsion
shot propulsion
command Reconstruction
command Loading
command "Light theme"
shot loading_light
# A new window, drawn in the lane above the plots, then taken back.
command Manoeuvres
xdotool mousemove 597 73 mousedown 1; sleep 0.3
for x in 602 606 610 612; do xdotool mousemove "$x" 73; sleep 0.2; done
xdotool mouseup 1; sleep "${settle:-8}"
shot drawn_light
xdotool key ctrl+z
sleep "${settle:-8}"
shot workbench_light
command "Dark theme"
command "Reset layout"
stop
for session in citation_aileron attas phlab_short_period; do
    recording=$(sed -n 's/^path = "\(\.\..*\)"/\1/p' "sessions/reference/$session.toml" | head -1)
    if [ ! -e "sessions/reference/$recording" ]; then
        echo "$session: left out, there is no sessions/reference/$recording"
        continue
    fi
    start "sessions/reference/$session.toml"
    command Reconstruction
    command Manoeuvres
    shot "$session"
    stop
done
