# A session of one's own recordings, sourced by shots.sh (SCENES=own_recording): RECORDINGS names them, files and folders, by colons.
IFS=: read -ra recordings <<<"${RECORDINGS:?give recordings, separated by colons}"
for recording in "${recordings[@]}"; do
    name=$(basename "${recording%.*}")
    start
    if [ -d "$recording" ]; then xdotool key ctrl+shift+n; else xdotool key ctrl+n; fi
    sleep 1.5
    xdotool type --delay 8 "$recording"; sleep 0.5
    xdotool key Return; sleep 1
    # A folder is entered by its name, then taken as it is.
    if [ -d "$recording" ]; then xdotool key Return; sleep 1; fi
    sleep "${settle:-8}"
    shot "own_${name}_roles"
    xdotool key Escape; sleep 0.5
    stop
done
