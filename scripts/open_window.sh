#!/usr/bin/env bash
# open_window.sh FILE TYPE: opens a file as a double click does under a virtual display and waits for doublet's window; part of
# check_deb.sh.
set -euo pipefail
file=$1 type=$2
found=$(gio info --attributes standard::content-type "$file" | sed -n 's/.*content-type: //p')
[[ $found == "$type" ]] || { echo "$file is taken for $found"; exit 1; }
export DISPLAY=:98 HOME=/tmp/home XDG_RUNTIME_DIR=/tmp/home
mkdir -p "$HOME" /tmp/.X11-unix
Xvfb "$DISPLAY" -screen 0 1600x1000x24 >/tmp/home/display.log 2>&1 &
display=$!
# Without its display the program ends.
trap 'kill "$display"; wait; rm -rf /tmp/home' EXIT
for _ in $(seq 100); do xwininfo -root >/dev/null 2>&1 && break; sleep 0.1; done
gio open "$file" >/dev/null 2>&1
for _ in $(seq 300); do
    window=$(xwininfo -root -tree | grep ' "doublet")' || true)
    # The title of a window that shows a session names it.
    if [[ $window == *"$(basename "$file")"* ]]; then
        echo "window: $(sed 's/^ *//' <<<"$window" | head -1)"
        exit 0
    fi
    sleep 0.1
done
echo "no window in 30 s: ${window:-none}"; exit 1
