# From the files of seven recorders to derivatives by the window alone, sourced by shots.sh (SCENES=recorders): start page, new session from
# a recording, an aircraft of few figures, the roles of the channels, the manoeuvres found, results, all as a new user types and clicks it.
# RECORDERS names the folder of the files, those of scripts/recorders.sh; ONLY some of them (csv jsbsim ...). Steps of the hand are
# counted, seconds are from the start page to the results on screen; the derivatives are those the window then exports.
folder=$(realpath "${RECORDERS:-../shared/data/formats}")
# Area, span, chord, mass and moments of inertia of the aircraft that flew, pilot and fuel included.
figures=(16.165 10.912 1.4935 852.8 2066.9 1876.8 3424.2)
sessions=$(mktemp -d)
table=$out/recorders.txt
# A key, and the frame that shows what it did: a busy machine needs a longer pause.
chord() { xdotool key "$1"; sleep "${pause:-0.4}"; }
typed() { xdotool type --delay 40 -- "$1"; sleep 0.5; }
hand() { steps=$((steps + 1)); [ -z "${TALK:-}" ] || echo "  step $steps: $1"; shift; "$@"; }
# Waits until two pictures in a row are the same: nothing is being read or computed.
still() {
    local before= now=
    for _ in $(seq 1 120); do
        now=$(import -window root rgb:- | md5sum)
        [ "$now" != "$before" ] || return 0
        before=$now
        sleep 0.4
    done
    echo "the window does not come to rest"; return 1
}
until_there() { for _ in $(seq 1 240); do compgen -G "$1" >/dev/null && return 0; sleep 0.25; done; echo "there is no $1"; return 1; }
answered() { typed "$1"; chord Return; }
# Figures of the aircraft from the field of its name on, one after the other, then the button that saves it.
described() {
    for figure in "${figures[@]}"; do chord Tab; typed "$figure"; done
    chord Tab; chord Tab; chord Tab; chord space
}
# The channel of a role, from its list at X Y: part of its name narrows the list, Return takes the first that is left. Then its travel, by the button that appears in its row.
channel() { click "$1" "$2"; answered "$3"; }
travel() { click "$1" "$2"; typed "$3"; chord Tab; typed "$4"; chord Tab; typed "$5"; chord Return; }
# What no recorder of pulses or of parts of full travel states: channel, what is recorded at neutral and elsewhere, the deflection there.
# The rows of elevator, aileron and rudder lie 24 points apart; X is that of the list and of the button.
controls() { # Y_OF_ELEVATOR then four words for each control
    local y=$1 control
    shift
    hand "Channels" xdotool mousemove 381 47 click 1
    sleep 1; still
    for control in elevator aileron rudder; do
        hand "channel of the $control" channel 357 "$y" "$1"
        hand "travel of the $control" travel 830 "$y" "$2" "$3" "$4"
        y=$((y + 24))
        shift 4
    done
}
of_dataflash() { controls 334 RCOU/C2 1500 2000 -35 RCOU/C5 1500 2000 25 RCOU/C4 1500 2000 -20; }
of_flightgear() { controls 334 elevator 0 1 23 'left ail' 0 1 -15 rudder 0 1 16; }
# NAME FILE [FUNCTION]: FUNCTION says what the recorder does not.
from() {
    local name=$1 file=$2 began took
    [[ -z ${ONLY:-} || " $ONLY " == *" $name "* ]] || return 0
    steps=0
    settle=3 start
    began=$SECONDS
    hand "New session from recording (Ctrl+N)" chord ctrl+n
    hand "the recording" answered "$folder/$file"
    sleep 0.5; still
    hand "Describe one (aircraft)" xdotool key Tab Tab space; sleep 0.5
    hand "its figures, Save the aircraft" described
    hand "its file" answered "$sessions/$name.aircraft"
    until_there "$sessions/$name.aircraft*"
    sleep 0.6; still
    [ -z "${3:-}" ] || "$3"
    still
    shot "recorder_${name}_1_roles"
    hand "Create session (Ctrl+Enter)" chord ctrl+Return
    sleep 1; still
    shot "recorder_${name}_2_manoeuvres"
    hand "Results (Ctrl+8)" chord ctrl+8
    still
    took=$((SECONDS - began))
    shot "recorder_${name}_3_results"
    hand "Save session (Ctrl+S)" chord ctrl+s
    hand "its name" answered "$sessions/$name"
    until_there "$sessions/$name.toml"
    chord ctrl+e; answered "$sessions/$name.results"
    until_there "$sessions/$name.results/results.json"
    sleep 1
    stop
    printf '%-50s %5s %4s  %s\n' "$file" "$steps" "$took" \
        "$(python3 scripts/print_derivatives.py "$sessions/$name.results/results.json")" | tee -a "$table"
}
printf '%-50s %5s %4s  %s\n' recorder steps s 'Cl_p, Cl_delta_a, Cm_alpha, Cm_delta_e, Cn_beta, Cn_delta_r' | tee "$table"
from csv generic_csv/05_units_row.csv
from jsbsim jsbsim_csv/c172p_doublet.csv
from mdf4 mdf4/three_groups_dz_deflate.mf4
from tdms tdms/groups_waveform.tdms
from parquet parquet/ns_utc_units_nulls_zstd.parquet
from dataflash ardupilot_dataflash/fixed_wing_synthetic.bin of_dataflash
from flightgear flightgear_csv/fg_log.csv of_flightgear
rm -rf "$sessions"
