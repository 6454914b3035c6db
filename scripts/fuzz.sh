#!/usr/bin/env bash
# Fuzzes every parser, led by coverage, a million executions each unless told otherwise: scripts/fuzz.sh [RUNS] [TARGET...]. Needs
# cargo-fuzz and a C++ compiler; RUSTC_BOOTSTRAP lets the stable toolchain take what cargo-fuzz asks of a nightly one. No sanitizer:
# the readers are safe code, and without one a run takes a third of the time; FUZZ_SANITIZER=address turns it on. A finding goes to
# fuzz/seeds once it is mended: the tests read what is there.
set -euo pipefail
cd "$(dirname "$0")/.."
export RUSTC_BOOTSTRAP=1
runs=${1:-1000000}
targets=("${@:2}")
[[ ${#targets[@]} -gt 0 ]] || mapfile -t targets < <(cargo fuzz list)
for target in "${targets[@]}"; do
    echo "== $target"
    mkdir -p "fuzz/corpus/$target"
    cargo fuzz run --sanitizer "${FUZZ_SANITIZER:-none}" "$target" "fuzz/corpus/$target" "fuzz/seeds/$target" -- \
        -runs="$runs" -max_len=20000 -timeout=10 -rss_limit_mb=2048
done
