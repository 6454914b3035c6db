#!/usr/bin/env bash
# Exports the linear models of the shipped session in all three forms, runs the very lines that the program prints for MATLAB (in Octave) and
# for Python, and compares the poles of what they load with the eigenvalues of the exported matrix: within 1e-9. Needs Octave with its control
# package, and Python with network access. The lines for Julia are not run. DOUBLET names the binary (default target/debug/doublet-cli).
set -euo pipefail
cd "$(dirname "$0")/.."
if ! octave-cli --quiet --eval 'pkg load control' > /dev/null 2>&1; then
    echo "check_linear: skipped, Octave with its control package is not installed (apt-get install octave octave-control)"
    exit 0
fi
doublet=$(realpath "${DOUBLET:-target/debug/doublet-cli}")
session=$(realpath sessions/demo.toml)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet numpy scipy pandas control
cd "$work"
for form in mat json csv; do
    "$doublet" linear "$session" --out "model.$form" > "said.$form"
    {
        echo 'pkg load control'
        sed -n 's/^matlab: \(.*\)$/\1;/p' "said.$form"
        echo 'printf("%.17g %.17g\n", [real(pole(sys)) imag(pole(sys))]'"'"');'
    } > "load_$form.m"
    octave-cli --quiet "load_$form.m" > "matlab.$form"
    {
        sed -n 's/^python: //p' "said.$form"
        echo 'for pole in sys.poles(): print(repr(float(pole.real)), repr(float(pole.imag)))'
    } > "load_$form.py"
    venv/bin/python "load_$form.py" > "python.$form"
done
venv/bin/python - <<'PY'
import json

import numpy as np

system = json.load(open("model.json"))["systems"]["longitudinal"]
exact = np.sort_complex(np.linalg.eigvals(np.array(system["A"])))
failed = False
for tool in ("matlab", "python"):
    for form in ("mat", "json", "csv"):
        poles = np.sort_complex([complex(*map(float, line.split())) for line in open(f"{tool}.{form}")])
        worst = float(np.max(np.abs(poles - exact))) if len(poles) == len(exact) else float("inf")
        failed |= not worst < 1e-9
        print(f"{tool} line, {form}: {len(poles)} poles, largest difference {worst:.1e} rad/s")
raise SystemExit(failed)
PY
