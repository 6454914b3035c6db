# The scenes of the pictures, sourced by shots.sh.
for session in citation_aileron attas phlab_short_period; do
    [ -e "sessions/$session.toml" ] || continue
    start "sessions/$session.toml"
    shot "$session"
    for panel in Innovations Model Correlation; do command "$panel"; done
    shot "${session}_model"
    for panel in "Fits and residuals" "Noise and filter" Log; do command "$panel"; done
    shot "${session}_noise"
    stop
done
