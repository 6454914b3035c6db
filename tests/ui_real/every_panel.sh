# Every panel of a session, sourced by shots.sh (SCENES=every_panel): SESSION names it, the shipped one without; THEME=light for the light theme,
# ONLY="Match Model" for some panels. SIZE and SCALE are those of shots.sh.
panels=("Flight" "Channels" "Ground track" "Cross plot" "Manoeuvres" "Gallery" "Manoeuvre map" "Preprocess" "Sensors" "Noise and filter"
    "Reconstruction" "Innovations" "Model" "Derivatives" "Experiments" "Fits and residuals" "Match" "3-D replay" "Propulsion" "Correlation"
    "Studies" "Sensitivity" "Frequency response" "Modes and levels" "Qualification" "Prior" "Enough" "Design" "Airframe" "Live" "Loading"
    "Report" "Log" "Shortcuts" "Summary")
start "${SESSION:-sessions/demo.toml}"
[ "${THEME:-dark}" = dark ] || command "Light theme"
xdotool key ctrl+8; sleep 1
command "Next manoeuvre"
for panel in "${panels[@]}"; do
    name=${panel// /_}
    [[ -z ${ONLY:-} || " $ONLY " == *" $name "* ]] || continue
    command "$panel"
    xdotool mousemove 2 2
    sleep "${pause:-0.5}"
    shot "panel_$name"
done
stop
