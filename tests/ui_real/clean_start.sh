# From a clean start to the report of a recording that does not ship, by keyboard alone, sourced by shots.sh
# (SCENES=clean_start): RECORDING names a file whose channel map is recognised. Prints the steps of the hand and the seconds they took.
recording=${RECORDING:?give a recording whose channel map is recognised}
work=$(mktemp -d)
steps=0
hand() { steps=$((steps + 1)); echo "step $steps: $1"; shift; "$@"; }
chord() { xdotool key "$1"; sleep 0.7; }
typed() { xdotool type --delay 4 "$1"; sleep 0.4; xdotool key Return; sleep 0.7; }
# Waits until something is on disk.
until_there() { for _ in $(seq 1 240); do compgen -G "$1" >/dev/null && return 0; sleep 0.25; done; echo "there is no $1"; return 1; }
settle=3 start
shot clean_1_start
began=$SECONDS
hand "New session from recording (Ctrl+N)" chord ctrl+n
hand "the recording" typed "$recording"
sleep "${reading:-4}"
shot clean_2_dialog
hand "Create session (Ctrl+Enter)" chord ctrl+Return
sleep "${computing:-8}"
shot clean_3_manoeuvres
hand "Results (Ctrl+8)" chord ctrl+8
shot clean_4_results
hand "Save session (Ctrl+S)" chord ctrl+s
hand "its name" typed "$work/session"
until_there "$work/session.toml"
hand "Write report (Ctrl+Shift+E)" chord ctrl+shift+e
hand "its folder" typed "$work/report"
until_there "$work/report/*.html"
sleep 2
shot clean_5_report
took=$((SECONDS - began))
ls -l "$work/report"
echo "$steps steps of the hand, $took s with every wait, no file edited: $(basename "$recording")"
rm -rf "$work"
stop
