# Whole pieces of work on the shipped flight by mouse and keyboard, timed, sourced by shots.sh (SCENES=must_show): manoeuvres marked anew and
# a gust excluded; filters and structures compared and the best made current. Each is saved and what it holds is counted.
work=$(mktemp -d)
chord() { xdotool key "$1"; sleep "${pause:-0.25}"; }
# Waits until nothing has changed on screen for two seconds.
still() {
    local before= now= same=0
    for _ in $(seq 1 400); do
        now=$(import -window root rgb:- | md5sum)
        [ "$now" = "$before" ] && same=$((same + 1)) || same=0
        [ "$same" -lt 4 ] || return 0
        before=$now
        sleep 0.5
    done
    echo "the window does not come to rest"; return 1
}
saved() {
    chord ctrl+shift+s; sleep 1.5
    xdotool type --delay 8 "$work/$1"; sleep 0.4
    chord Return
    for _ in $(seq 1 120); do [ -e "$work/$1.toml" ] && return 0; sleep 0.25; done
    echo "$1 was not saved"; return 1
}

settle=3 start sessions/demo.toml
still
began=$SECONDS
chord ctrl+5
# The manoeuvres of the session go: all are marked anew, every fifth with another end.
chord ctrl+shift+a; chord Delete
for at in $(seq 1 50); do
    chord y
    if [ $((at % 6)) = 0 ]; then
        chord w; chord a
        for _ in $(seq 1 12); do xdotool key ctrl+Right; done
        chord bracketright
    fi
done
chord w
# A gust in the last one: dragged over with Alt in the middle of a plot.
xdotool mousemove 600 300; sleep 0.3
xdotool keydown alt mousedown 1
for x in 610 620 640 660; do xdotool mousemove $x 300; sleep 0.05; done
xdotool mouseup 1 keyup alt
marked=$((SECONDS - began))
still
shot must_marked
saved marked
stop
python3 - "$work/marked.toml" "$marked" "$((SECONDS - began))" <<'PYTHON'
import sys, tomllib
session = tomllib.load(open(sys.argv[1], "rb"))
windows = session["manoeuvre"]
excluded = sum(bool(window.get("excluded")) for window in windows)
print(f"{len(windows)} manoeuvres marked, {excluded} with an excluded part: {sys.argv[2]} s of hand, {sys.argv[3]} s with every result and the file")
PYTHON

settle=3 start sessions/demo.toml
still
began=$SECONDS
chord ctrl+7
command "Experiments"
add() { click 265 131; for at in "$@"; do click $at; done; }
add "242 161"
add "255 242"
for y in 280 334 388; do add "282 $y" "535 $y"; done
click 598 238
hand=$((SECONDS - began))
still
# The best of them: the first below the session as it is.
click 173 296
shot must_compared
click 190 542
still
took=$((SECONDS - began))
shot must_chosen
saved compared
stop
python3 - "$work/compared.toml" "$hand" "$took" <<'PYTHON'
import sys, tomllib
session = tomllib.load(open(sys.argv[1], "rb"))
print(f"{len(session["experiment"])} experiments: {sys.argv[2]} s of hand, {sys.argv[3]} s with every result and the best made current")
PYTHON
rm -rf "$work"
