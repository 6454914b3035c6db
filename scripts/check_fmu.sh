#!/usr/bin/env bash
# Flies the Functional Mock-up Unit of the shipped session in a public runner (FMPy), in co-simulation and in model exchange, compares
# both with each other and with the unit's own start, and flies the aircraft exported for JSBSim beside it. Needs Python with network
# access; prints what differed. DOUBLET names a binary that is there, and DOUBLET_FMU_LIBRARY the unit's library; both are built otherwise.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [[ -z ${DOUBLET:-} ]]; then
    cargo build --workspace --lib
    cargo build --workspace --bin doublet-cli
fi
doublet=$(realpath "${DOUBLET:-target/debug/doublet-cli}")
"$doublet" fmu sessions/demo.toml --out "$work/aircraft.fmu"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet fmpy numpy jsbsim
"$work/venv/bin/python" scripts/check_fmu.py "$work/aircraft.fmu"
"$doublet" export sessions/demo.toml --format jsbsim --out "$work/jsbsim"
"$work/venv/bin/python" scripts/check_jsbsim.py "$work/jsbsim" "$work/aircraft.fmu"
