#!/usr/bin/env bash
# Builds the Python wheel, installs it into a clean environment, runs it in a root with Python and NumPy alone, its tests (with mypy --strict
# and stubtest) and the notebooks of docs/notebooks in the environment, and prints its size and how long it takes to import.
# DOUBLET_WHEEL_PROFILE=dev builds quickly (the default is release), DOUBLET_WHEEL=FILE takes a wheel that was built. Needs Python 3.10 or
# newer, its venv module and a package index; nothing of Rust reaches the environment.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
wheel=${DOUBLET_WHEEL:-}
if [[ -z $wheel ]]; then
    python3 -m venv "$work/build"
    "$work/build/bin/pip" install --quiet 'maturin>=1.10,<2'
    (cd crates/python && CARGO_TARGET_DIR=../../target/python "$work/build/bin/maturin" build --quiet \
        --profile "${DOUBLET_WHEEL_PROFILE:-release}" --out "$work/wheels" -i python3)
    wheel=$(ls "$work"/wheels/*.whl)
fi
# Where the program is, its results are compared with those of the package; it is built here where cargo is there.
program=${DOUBLET:-}
if [[ -z $program ]] && command -v cargo >/dev/null; then
    cargo build --quiet --locked --workspace --bin doublet-cli
    program=$PWD/target/debug/doublet-cli
fi
python3 -m venv "$work/bare"
"$work/bare/bin/pip" install --quiet "$wheel"
echo "wheel: $(basename "$wheel"), $(($(stat -c %s "$wheel") / 1000)) kB"
(cd "$work" && PATH=/usr/bin:/bin "$work/bare/bin/python" -c '
import time
import numpy
start = time.perf_counter()
import doublet as db
print(f"import behind NumPy: {1e3 * (time.perf_counter() - start):.0f} ms; doublet {db.__version__}, {db.instructions}")
start = time.perf_counter()
verdict = db.run(db.Session.load("builtin:demo")).verdict["level"]
print(f"shipped flight: verdict {verdict}, {time.perf_counter() - start:.2f} s")')
scripts/check_python_root.sh "$work/bare"
"$work/bare/bin/pip" install --quiet pytest pandas polars xarray pyarrow matplotlib control scikit-learn joblib dask uncertainties mypy nbformat nbclient ipykernel
tests=$PWD/crates/python/tests
(cd "$work" && DOUBLET_PROGRAM=$program MPLBACKEND=Agg DOUBLET_NOTEBOOKS=$OLDPWD/docs/notebooks \
    "$work/bare/bin/python" -m pytest -q -p no:cacheprovider "$tests")
