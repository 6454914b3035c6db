# The shipped flight's manoeuvres flown again ten times as fast, watched in the panel Live.
start "${SESSION:-sessions/demo.toml}"
command "Live"
sleep 1
click "${WATCH_X:-40}" "${WATCH_Y:-180}"
sleep "${WATCHED_S:-30}"
shot live
stop
