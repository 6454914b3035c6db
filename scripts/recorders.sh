#!/usr/bin/env bash
# From the files of seven recorders to derivatives, by the command line alone: `doublet new --guess` and `doublet run`, timed. No file is
# edited; what no recorder states, the travel of servos, is said by --role. All hold the same flight of JSBSim's c172p.
# scripts/recorders.sh [FOLDER]; DOUBLET names the binary (default target/debug/doublet-cli).
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(realpath "${1:-../shared/data/formats}")
doublet=$(realpath "${DOUBLET:-target/debug/doublet-cli}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Area, span, chord, mass and inertia of the aircraft that flew, pilot and fuel included.
aircraft=(--area 16.165 --span 10.912 --chord 1.4935 --mass 852.8 --inertia 2066.9,1876.8,3424.2)
printf '%-34s %6s %6s %5s  %s\n' recorder new,s run,s roles 'Cl_p, Cl_delta_a, Cm_alpha, Cm_delta_e, Cn_beta, Cn_delta_r'
from() { # NAME FILE [OPTIONS...]
    local name=$1 file=$2 session=$work/$1.toml begun between ended
    begun=$(date +%s.%N)
    "$doublet" new "$folder/$file" --guess "${aircraft[@]}" "${@:3}" -o "$session" > "$work/$name.new"
    between=$(date +%s.%N)
    # Exit code 3: there is a verdict, and it is not good.
    "$doublet" run "$session" --out "$work/$name" > "$work/$name.run" || [[ $? == 3 ]]
    ended=$(date +%s.%N)
    printf '%-34s %6.1f %6.1f %5s  %s\n' "$file" "$(awk "BEGIN { print $between - $begun }")" "$(awk "BEGIN { print $ended - $between }")" \
        "$(grep -c '^  [a-z_]*: ' "$work/$name.new")" "$(python3 scripts/print_derivatives.py "$work/$name/results.json")"
}
from csv generic_csv/05_units_row.csv
from jsbsim jsbsim_csv/c172p_doublet.csv
from mdf4 mdf4/three_groups_dz_deflate.mf4
from tdms tdms/groups_waveform.tdms
from parquet parquet/ns_utc_units_nulls_zstd.parquet
from dataflash ardupilot_dataflash/fixed_wing_synthetic.bin --role delta_e=C2,source=RCOU,unit=deg,scale=-0.07,offset=-1500 \
    --role delta_a=C5,source=RCOU,unit=deg,scale=0.05,offset=-1500 --role delta_r=C4,source=RCOU,unit=deg,scale=-0.04,offset=-1500
from flightgear flightgear_csv/fg_log.csv --role 'delta_e=elevator (norm),unit=deg,scale=23' --role 'delta_r=rudder (norm),unit=deg,scale=16' \
    --role 'delta_a=left aileron (norm),unit=deg,scale=-15'
