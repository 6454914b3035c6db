#!/usr/bin/env bash
# Opens the workbench in a real window under a virtual display, clicks and drags as a user, and takes pictures.
# usage: tests/ui_real/shots.sh OUT_FOLDER [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:?give a folder for the pictures}
program=${2:-target/release/doublet}
mkdir -p "$out"
display=:$((90 + RANDOM % 400))
home=$(mktemp -d)
# SIZE is that of the screen, SCALE that of its text.
size=${SIZE:-1600x1000}
width=${size%x*} height=${size#*x}
Xvfb "$display" -screen 0 "${size}x24" >/dev/null 2>&1 &
server=$!
window=
finish() {
    [ -n "$window" ] && kill "$window" 2>/dev/null || true
    kill "$server" 2>/dev/null || true
    rm -rf "$home"
}
trap finish EXIT
sleep 1
export DISPLAY=$display HOME=$home XDG_DATA_HOME=$home/data LIBGL_ALWAYS_SOFTWARE=1
export WINIT_X11_SCALE_FACTOR=${SCALE:-1}

# Starts the program and waits for its window.
start() {
    "$program" "$@" &
    window=$!
    id=$(timeout 60 xdotool search --sync --onlyvisible --pid "$window" | tail -1)
    xdotool windowmove "$id" 0 0 windowsize "$id" "$width" "$height"
    xdotool windowfocus --sync "$id" mousemove "$((width / 2))" "$((height - 10))"
    sleep "${settle:-8}"
}

stop() {
    kill "$window" 2>/dev/null || true
    wait "$window" 2>/dev/null || true
    window=
}

# A picture of the whole window, in 256 colours to keep it small.
shot() {
    sleep 1
    import -window root +dither -colors 255 -depth 8 "png8:$out/$1.png"
    echo "$out/$1.png $(stat -c %s "$out/$1.png") bytes"
}

# A command by its name, through the palette.
command() {
    xdotool key ctrl+p; sleep 0.6
    xdotool type --delay 15 "$1"; sleep 0.5
    xdotool key Return; sleep 0.8
}

click() { xdotool mousemove "$1" "$2"; sleep 0.2; xdotool click 1; sleep 0.5; }

source "tests/ui_real/${SCENES:-scenes}.sh"
