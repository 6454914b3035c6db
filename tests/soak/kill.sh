#!/usr/bin/env bash
# Kills doublet at random moments and looks at what is left: tests/soak/kill.sh [KILLS] [COMMAND...]. Commands: run report export batch simulate.
# DOUBLET names the binary (default target/release/doublet-cli). Prints a line of counts per command; exit code 1 for any breach.
set -uo pipefail
cd "$(dirname "$0")/../.."
doublet=$(realpath "${DOUBLET:-target/release/doublet-cli}")
kills=${1:-50}
commands=("${@:2}")
[[ ${#commands[@]} -gt 0 ]] || commands=(run report export batch simulate)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
breaches=0
breach() { echo "  breach: $1"; breaches=$((breaches + 1)); }

# Two sessions of one short flight, which differ in every file of results.
python3 - "$work" <<'PY'
import math, sys
names = "t ax ay az p q r phi theta psi V h alpha beta delta_e delta_a delta_r".split()
rows = [",".join(names)]
for k in range(400):
    t = 0.02 * k
    fast, slow = math.sin(6 * t) + 0.3 * math.sin(11 * t), math.cos(2.5 * t) + 0.3 * math.cos(5 * t)
    row = [t, 0.3 + 0.05 * fast, 0.1 * slow, -9.7 + 0.8 * fast, 4 * slow, 3 * fast, 0.8 * slow, 5 * math.sin(2.5 * t), 4 - 0.5 * slow,
           90 + 0.3 * t, 130 + 0.2 * slow, 3000 - 0.5 * t, 4.5 + 0.6 * fast, 0.4 * slow, -1 - 1.5 * math.sin(6 * t + 0.6),
           1.2 * math.cos(2.5 * t + 1), 0.5 * fast + 0.2 * math.sin(3 * t)]
    rows.append(",".join(f"{value:.6f}" for value in row))
open(f"{sys.argv[1]}/flight.csv", "w").write("\n".join(rows) + "\n")
units = dict(ax="m/s^2", ay="m/s^2", az="m/s^2", p="deg/s", q="deg/s", r="deg/s", V="m/s", h="m")
roles = {"V": "airspeed", "h": "altitude"}
lines = ['format = "doublet channel map"', "version = 1", 'name = "flight"', "[[time]]", 'source = "*"', 'channel = "t"', 'unit = "s"', "[roles]"]
lines += [f'{roles.get(n, n)} = {{ channel = "{n}", unit = "{units.get(n, "deg")}" }}' for n in names[1:]]
open(f"{sys.argv[1]}/map.toml", "w").write("\n".join(lines) + "\n")
session = """format = "doublet session"
version = 3
title = "{name}"
aircraft = "builtin:attas_vfw614"
[filter]
gravity_m_s2 = 9.8
[filter.process_noise]
ax = {ax}
[preparation]
remove_thrust = false
[model]
CX = ["1", "alpha"]
CY = ["1", "beta"]
CZ = ["1", "alpha"]
Cl = ["1", "pb/2V", "delta_a"]
Cm = ["1", "alpha", "delta_e"]
Cn = ["1", "beta", "delta_r"]
[[flight]]
name = "flight"
[[flight.recording]]
path = "flight.csv"
channel_map = "map.toml"
[[window]]
name = "w"
flight = "flight"
start_s = 0.5
end_s = 7.5
"""
for name, ax in (("a", 0.02), ("b", 0.03)):
    open(f"{sys.argv[1]}/{name}.toml", "w").write(session.format(name=name, ax=ax))
sweep = 'format = "doublet sweep"\nversion = 1\nsession = "a.toml"\n[[vary]]\nsetting = "filter.process_noise.ax"\nvalues = [%s]\n'
open(f"{sys.argv[1]}/sweep.toml", "w").write(sweep % ", ".join(f"{1e-3 * (k + 10):.3f}" for k in range(40)))
PY

call() { # COMMAND SESSION FOLDER
    case $1 in
        run) "$doublet" run "$work/$2.toml" --out "$3" ;;
        report) cp "$work/$2.toml" "$work/small.toml"; "$doublet" report "$work/small.toml" --out "$3" --sections overview,derivatives --format html ;;
        export) cp "$work/$2.toml" "$work/small.toml"; "$doublet" export "$work/small.toml" --out "$3" ;;
        batch) "$doublet" batch "$work/sweep.toml" --out "$3.csv" ;;
        simulate) "$doublet" simulate multisine --out "$3" ;;
    esac > /dev/null 2>&1
}

# Hashes of the files of doublet; those of the user are looked at by themselves.
state() { (cd "$1" && find . -type f ! -name mine.txt ! -path './plots/*' ! -name doublet_manifest.json -print0 | sort -z | xargs -0 sha256sum | sha256sum); }

for command in "${commands[@]}"; do
    out=$work/$command
    hit=0
    if [[ $command == batch ]]; then
        call batch - "$work/whole"
        for ((kill = 0; kill < kills; kill++)); do
            call batch - "$out" & pid=$!
            sleep "$((RANDOM % 2)).$(printf %03d $((RANDOM % 1000)))"
            child=$(pgrep -P "$pid" -x "$(basename "$doublet")" || true)
            [[ -n $child ]] && builtin kill -9 $child 2> /dev/null && hit=$((hit + 1))
            wait "$pid" 2> /dev/null
        done
        call batch - "$out" || breach "batch does not finish after kills"
        cmp -s "$work/whole.csv" "$out.csv" || breach "the table differs from that of a batch nobody killed"
        [[ -z $(find "$out.csv.runs" -name '*.doublet-part') ]] || breach "batch leaves litter"
    elif [[ $command == simulate ]]; then
        # Writes no folder that is there: it appears whole or not at all.
        begun=$(date +%s%N); call simulate - "$out"; took=$((($(date +%s%N) - begun) / 1000000))
        whole=$(state "$out")
        for ((kill = 0; kill < kills; kill++)); do
            rm -rf "$out"
            call simulate - "$out" & pid=$!
            delay=$((kill % 3 == 0 ? RANDOM % took : took * 9 / 10 + RANDOM % (took / 10 + 5)))
            sleep "$(printf '%d.%03d' $((delay / 1000)) $((delay % 1000)))"
            child=$(pgrep -P "$pid" -x "$(basename "$doublet")" || true)
            [[ -n $child ]] && builtin kill -9 $child 2> /dev/null && hit=$((hit + 1))
            wait "$pid" 2> /dev/null
            [[ ! -e $out || $(state "$out") == "$whole" ]] || breach "simulate: kill $kill left a part of a flight"
        done
        rm -rf "$out"; call simulate - "$out"
        [[ $(state "$out") == "$whole" ]] || breach "simulate: the run after the kills does not give what it gave"
        left=$(find "$work" -maxdepth 1 -name '.*doublet*' | wc -l)
        [[ $left == 0 ]] || breach "simulate: $left leftovers after the next run"
    else
        call $command b "$out"; b=$(state "$out"); rm -rf "$out"
        call $command a "$out"; a=$(state "$out")
        echo mine > "$out/mine.txt"; mkdir "$out/plots"; echo p > "$out/plots/a.png"
        [[ $a != "$b" ]] || breach "$command: the two sessions give the same files"
        begun=$(date +%s%N); call $command b "$out"; took=$((($(date +%s%N) - begun) / 1000000))
        for ((kill = 0; kill < kills; kill++)); do
            session=$([[ $((kill % 2)) == 0 ]] && echo a || echo b)
            call $command $session "$out" & pid=$!
            # Two kills of three in the last tenth of the run, where it writes.
            delay=$((kill % 3 == 0 ? RANDOM % took : took * 9 / 10 + RANDOM % (took / 10 + 5)))
            sleep "$(printf '%d.%03d' $((delay / 1000)) $((delay % 1000)))"
            child=$(pgrep -P "$pid" -x "$(basename "$doublet")" || true)
            [[ -n $child ]] && builtin kill -9 $child 2> /dev/null && hit=$((hit + 1))
            wait "$pid" 2> /dev/null
            now=$(state "$out")
            [[ $now == "$a" || $now == "$b" ]] || breach "$command: kill $kill left files that are of neither run"
            [[ $(cat "$out/mine.txt" "$out/plots/a.png") == $'mine\np' ]] || breach "$command: kill $kill cost a file of the user"
        done
        call $command a "$out"
        [[ $(state "$out") == "$a" ]] || breach "$command: the run after the kills does not give what it gave"
        left=$(find "$work" "$out" -maxdepth 1 -name '.*doublet*' | wc -l)
        [[ $left == 0 ]] || breach "$command: $left leftovers after the next run"
    fi
    echo "$command: $kills runs, $hit killed"
done
exit $((breaches > 0))
