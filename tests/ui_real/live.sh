# A session's first flight flown again, watched in the panel Live: SESSION names it, the shipped one without; SPEED says how fast it is flown.
start "${SESSION:-sessions/demo.toml}"
command "Live"
sleep 1
click 455 131
xdotool type --delay 8 "alpha=-4deg:14deg n_z=0.5:2"
# So many times as fast as it was flown: the first manoeuvre begins after 17 minutes.
click 313 131
xdotool type --delay 8 "${SPEED:-40}"
xdotool key Return; sleep 0.5
click 39 186
sleep "${WATCHED_S:-45}"
# The derivative whose estimate is drawn.
click 366 863
shot live
stop
