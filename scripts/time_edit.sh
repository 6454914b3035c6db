#!/usr/bin/env bash
# Times the edit loop of an estimator: everything built, one line of crates/core/src/estimate/least_squares.rs changed, core built again and
# the unit tests of `estimate` run; then all of `cargo t`. Prints seconds. The file is as it was afterwards.
set -euo pipefail
cd "$(dirname "$0")/.."
file=crates/core/src/estimate/least_squares.rs
kept=$(mktemp)
cp -p "$file" "$kept"
trap 'cp -p "$kept" "$file"; rm "$kept"' EXIT
seconds() {
    local start=$EPOCHREALTIME
    "$@" >/dev/null
    awk -v start="$start" -v end="$EPOCHREALTIME" 'BEGIN { printf "%.1f s\n", end - start }'
}
cargo t --quiet --no-run
echo "// An edit." >>"$file"
echo "one edit, core built and the tests of estimate run: $(seconds cargo test --quiet --locked -p doublet-core -p doublet-dynamics -p doublet-engine --lib estimate)"
echo "// Another." >>"$file"
echo "one edit, cargo t: $(seconds cargo t --quiet)"
