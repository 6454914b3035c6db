#!/usr/bin/env bash
# Flies the Functional Mock-up Unit of the shipped session in a public runner (FMPy), in co-simulation and in model exchange, and compares
# both with each other and with the unit's own start. Needs Python with network access; prints what differed.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo build --workspace --lib
cargo run --quiet --workspace --bin doublet-cli -- fmu sessions/demo.toml --out "$work/aircraft.fmu"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet fmpy numpy
"$work/venv/bin/python" scripts/check_fmu.py "$work/aircraft.fmu"
