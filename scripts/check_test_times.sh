#!/usr/bin/env bash
# Holds the tests to their time: scripts/check_test_times.sh LOG, where LOG is what `cargo test --workspace` printed. Prints the
# slowest binaries; exit code 1 where one takes longer than 700 s or all together longer than 1800 s, with which `.ci/run` stays
# below an hour on two cores. DOUBLET_TEST_SECONDS and DOUBLET_ALL_TESTS_SECONDS set other limits.
set -euo pipefail
one=${DOUBLET_TEST_SECONDS:-700} all=${DOUBLET_ALL_TESTS_SECONDS:-1800}
awk -v one="$one" -v all="$all" '
    $1 == "Running" || $1 == "Doc-tests" { name = $2 == "unittests" ? $NF : $2 }
    /^test result:/ { sub(/s$/, "", $NF); seconds[name] += $NF; total += $NF }
    END {
        for (name in seconds) print seconds[name], name | "sort -rn | head -5"
        close("sort -rn | head -5")
        printf "%d s of tests\n", total
        for (name in seconds) if (seconds[name] > one) { printf "over %d s: %s\n", one, name; over = 1 }
        if (total > all) { printf "over %d s in all\n", all; over = 1 }
        exit over
    }' "$1"
