#!/usr/bin/env bash
# Fuzzes every parser, led by coverage, a million executions each unless told otherwise: scripts/fuzz.sh [-j JOBS] [RUNS] [TARGET...]. JOBS
# processes share the executions of a target (1 unless given). At the end it prints the executions and failures of every target, and how
# far the recordings of recording_chain came, which fuzz/counts keeps. Needs cargo-fuzz and a C++ compiler; RUSTC_BOOTSTRAP lets the stable
# toolchain take what cargo-fuzz asks of a nightly one. No sanitizer: the readers are safe code, and without one a run takes a third of the
# time; FUZZ_SANITIZER=address turns it on. A finding goes to fuzz/seeds once it is mended: the tests read what is there.
set -euo pipefail
cd "$(dirname "$0")/.."
export RUSTC_BOOTSTRAP=1
jobs=1
while getopts j: option; do
    case $option in
        j) jobs=$OPTARG ;;
        *) exit 2 ;;
    esac
done
shift $((OPTIND - 1))
runs=${1:-1000000}
targets=("${@:2}")
[[ ${#targets[@]} -gt 0 ]] || mapfile -t targets < <(cargo fuzz list)
counts=$PWD/fuzz/counts
mkdir -p "$counts"
export DOUBLET_FUZZ_COUNTS=$counts

# One of the jobs of a target; its output is its log.
fuzz_one() {
    cargo fuzz run --sanitizer "${FUZZ_SANITIZER:-none}" "$1" "fuzz/corpus/$1" "fuzz/seeds/$1" -- -runs="$2" -max_len=20000 \
        -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 >"$counts/$1-job$3.log" 2>&1
}

failed=0
for target in "${targets[@]}"; do
    echo "== $target"
    mkdir -p "fuzz/corpus/$target"
    rm -f "$counts/$target"-*
    cargo fuzz build --sanitizer "${FUZZ_SANITIZER:-none}" "$target"
    pids=()
    for ((job = 1; job <= jobs; job++)); do
        fuzz_one "$target" $(((runs + jobs - 1) / jobs)) "$job" &
        pids+=($!)
    done
    failures=0
    for pid in "${pids[@]}"; do
        wait "$pid" || failures=$((failures + 1))
    done
    failed=$((failed + failures))
    executed=$(awk '/stat::number_of_executed_units:/ { sum += $2 } END { print sum + 0 }' "$counts/$target"-job*.log)
    echo "$executed executions, $failures of $jobs jobs failed" | tee "$counts/$target-total.txt"
done
echo "== counts"
for target in "${targets[@]}"; do
    echo "$target: $(cat "$counts/$target-total.txt")"
done
# Steps at which the recordings of the chain ended, all jobs together.
if [[ " ${targets[*]} " == *" recording_chain "* ]]; then
    cat "$counts"/recording_chain-[0-9]*.txt | tr ',' '\n' |
        awk 'NF == 2 { sum[$1] += $2 } END { for (step in sum) printf "  %s %d\n", step, sum[step] }' | sort
fi
exit $((failed > 0))
