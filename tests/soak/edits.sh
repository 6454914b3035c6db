#!/usr/bin/env bash
# Edits one window many times in the workbench and looks at the memory it holds: tests/soak/edits.sh [EDITS].
set -euo pipefail
cd "$(dirname "$0")/../.."
DOUBLET_SOAK_EDITS=${1:-10000} cargo test --workspace --test ui -- --ignored --nocapture soak::memory_is_flat_over_many_edits
