#!/usr/bin/env bash
# The loop design -> simulate -> run -> debrief over several seeds, with the table of docs/planning.md: promised, obtained, true.
# Usage: scripts/measure_loop.sh FOLDER [KIND [FLIGHTS [FIRST_SEED [TIME_S]]]]; the program is $DOUBLET, or target/release/doublet-cli.
set -euo pipefail
folder=${1:?a folder for design, flights and table}
kind=${2:-3-2-1-1}
flights=${3:-8}
first=${4:-1}
time_s=${5:-120}
doublet=${DOUBLET:-target/release/doublet-cli}

"$doublet" design builtin:demo --kind "$kind" --time "$time_s" --rounds 0 --fuel 200 --out "$folder" > "$folder.log"
given=()
for seed in $(seq "$first" $((first + flights - 1))); do
    "$doublet" simulate "$folder/design_scenario.toml" --seed "$seed" --out "$folder/flight$seed" >> "$folder.log"
    given+=(--flight "$folder/flight$seed")
done
"$doublet" debrief "$folder" "${given[@]}" --out "$folder/debrief" --format html
