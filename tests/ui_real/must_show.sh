# Whole pieces of work on the shipped flight by mouse and keyboard, timed, sourced by shots.sh (SCENES=must_show): manoeuvres marked anew and
# a gust excluded; filters and structures compared and the best made current; three causes of a stranger's session applied. Each is saved,
# what it holds is counted, and too few or too slow is an error.
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
# Waits until two pictures are the same: the last key or move is drawn.
rest() {
    local before= now=
    for _ in $(seq 1 20); do
        sleep "${pause:-0.25}"
        now=$(import -window root rgb:- | md5sum)
        [ "$now" != "$before" ] || return 0
        before=$now
    done
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
# The manoeuvres of the session go: all are marked anew, every fifth with a later end, dragged by its edge.
chord ctrl+shift+a; chord Delete
for at in $(seq 1 50); do
    chord y
    if [ $((at % 6)) = 0 ]; then
        # The edge is taken once it is drawn at its place and the pointer over it is seen.
        chord w; rest
        xdotool mousemove 828 300; rest
        xdotool mousedown 1; sleep 0.1
        for x in 832 840 850; do xdotool mousemove $x 300; sleep 0.1; done
        xdotool mouseup 1; sleep 0.2
    fi
done
chord w; rest
# A gust in the last one: dragged over with Alt in the middle of a plot.
xdotool mousemove 600 300; rest
xdotool keydown alt; sleep 0.2; xdotool mousedown 1; sleep 0.1
for x in 610 620 640 660; do xdotool mousemove $x 300; sleep 0.05; done
xdotool mouseup 1 keyup alt
marked=$((SECONDS - began))
still
shot must_marked
saved marked
stop
"$program" propose manoeuvres sessions/demo.toml --json >"$work/proposed.json"
python3 - "$work/marked.toml" "$work/proposed.json" "$marked" "$((SECONDS - began))" <<'PYTHON'
import json, sys, tomllib
manoeuvres = tomllib.load(open(sys.argv[1], "rb"))["manoeuvre"]
proposed = {row[1]: row[2] for row in json.load(open(sys.argv[2]))["tables"][0]["rows"]}
excluded = sum(bool(one.get("exclude")) for one in manoeuvres)
corrected = sum(proposed.get(one["start_s"]) != one["end_s"] for one in manoeuvres)
hand, took = sys.argv[3:]
print(f"{len(manoeuvres)} manoeuvres marked, {corrected} of them corrected, {excluded} with an excluded part: {hand} s of hand, {took} s with every result and the file")
assert len(manoeuvres) >= 35 and corrected >= 5 and excluded == 1 and int(took) < 180
PYTHON

settle=3 start sessions/demo.toml
still
began=$SECONDS
chord ctrl+7
command "Experiments"
# A menu takes a frame to open, on a busy machine a long one.
add() { click 265 131; for at in "$@"; do sleep "${pause:-0.4}"; click $at; done; sleep "${pause:-0.4}"; }
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
experiments = len(session["experiment"])
print(f"{experiments} experiments: {sys.argv[2]} s of hand, {sys.argv[3]} s with every result and the best made current")
assert experiments >= 18 and int(sys.argv[3]) < 120
PYTHON

# A stranger's session of the same flight: the first cause of the summary is applied, three times.
python3 tests/ui_real/spoilt.py "$work"
settle=3 start "$work/session.toml"
still
began=$SECONDS
chord ctrl+8; still
# What a fix has done stays in its row until the pointer has left the list.
apply() { click "$1" "$2"; still; xdotool mousemove 2 990; still; }
apply 587 408
apply 582 373
apply 630 287
took=$((SECONDS - began))
shot must_mended
saved mended
stop
verdict() { "$program" run "$work/$1.toml" --out "$work/$1" | head -1; }
echo "three causes applied, $took s with every result: $(verdict session), then $(verdict mended)"
verdict mended | grep -q "^verdict good"
rm -rf "$work"
