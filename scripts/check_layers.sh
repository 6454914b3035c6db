#!/usr/bin/env bash
# Checks the invariants of ARCHITECTURE.md that a command can check. Prints every breach; exit code 1 if there is one.
set -euo pipefail
cd "$(dirname "$0")/.."
breaches=0
breach() { echo "layer check: $1"; breaches=1; }

# 1. src -> cli -> report -> engine -> fmu -> dynamics -> core, python -> cli; these crates never reach a GUI crate, and none reaches
# one above it.
gui='egui|eframe|egui_plot|egui_extras|egui_tiles|egui_kittest|winit|glow|glutin|rfd|wgpu'
declare -A above=([doublet-core]='doublet-dynamics|doublet-fmu|doublet-engine|doublet-report|doublet-cli|doublet'
    [doublet-dynamics]='doublet-fmu|doublet-engine|doublet-report|doublet-cli|doublet' [doublet-engine]='doublet-report|doublet-cli|doublet'
    [doublet-fmu]='doublet-engine|doublet-report|doublet-cli|doublet'
    [doublet-report]='doublet-cli|doublet' [doublet-cli]='doublet' [doublet-python]='doublet')
for crate in doublet-core doublet-dynamics doublet-fmu doublet-engine doublet-report doublet-cli doublet-python; do
    tree=$(cargo tree --locked -p "$crate" -e normal --prefix none --format '{p}' | awk '{print $1}' | sort -u)
    while read -r hit; do breach "$crate depends on $hit"; done < <(grep -xE "$gui|${above[$crate]}" <<<"$tree" || true)
done

# 2. The rooms of every crate stand in an order and use only those before them.
while read -r hit; do breach "$hit"; done < <(scripts/check_rooms.py 2>&1 || true)
core=crates/core/src

# 4. Core knows no session, starts no thread and reads no clock.
while read -r hit; do breach "core starts threads or reads a clock: $hit"; done \
    < <(grep -rnE 'std::thread|SystemTime::now|Instant::now' "$core" | grep -v '^[^:]*:[0-9]*: *//' || true)

# 5. Only engine/run starts threads; the app computes nothing, so it never calls the numerics.
while read -r hit; do breach "thread started outside engine/run: $hit"; done \
    < <(grep -rnE 'thread::(spawn|Builder)' crates/engine/src crates/report/src crates/cli/src | grep -v '^crates/engine/src/run/' || true)
while read -r hit; do breach "the app computes: $hit"; done \
    < <(grep -rnE 'doublet_core::(estimate|reconstruct|model|prep)::(reconstruct|least_squares|coefficients|variables|regressors)\b' src || true)

# 8. Stages and studies reach files through their context alone, and their errors are more than text.
engine=crates/engine/src
while read -r hit; do breach "a stage reads a file past its context: $hit"; done \
    < <(grep -rnE 'std::fs|File::open|load::(read_text|read_bytes)|\bread_(text|bytes)\(' "$engine/stage" "$engine/study" | grep -v 'context\.read_text' || true)
while read -r hit; do breach "an error of the engine is text: $hit"; done \
    < <(grep -rnE -- '-> Result<.*, String>' "$engine/graph" "$engine/stage" "$engine/study" "$engine/run" || true)

# 6. A file over 600 lines is a room that wants a wall.
while read -r lines file; do
    [[ $file != total && $lines -gt 600 ]] && breach "$file has $lines lines"
done < <(find src crates -name '*.rs' -not -path '*/target/*' -exec wc -l {} +)

# 7. Inside reconstruct a file imports from the file that defines, by its full path, and only what stands below its folder here;
# packed knows of filter only what a step is given and yields. No circle between files.
declare -A uses=([numeric]='' [error]='' [model]='numeric' [settings]='model' [deviations]='' [data]='deviations model' [measured]='data deviations error model' [filter]='data settings model numeric'
    [outliers]='data settings model' [events]='filter/step data error settings model' [smoother]='filter data error settings model'
    [packed]='filter/backend filter/parameters filter/step settings model numeric' [collect]='filter/step events data deviations error settings model'
    [pass]='collect events filter/backend filter/parameters filter/step numeric'
    [sequential]='packed filter collect events data error settings model'
    [run]='packed outliers smoother filter pass collect events data error settings model'
    [consistency]='data model numeric' [tuning]='run pass collect data error settings model')
room=$core/reconstruct
imports=$(while read -r file; do
    name=${file#"$room"/}
    sed '/^#\[cfg(test)\]$/q' "$file" | grep -oE '(crate::reconstruct::[A-Za-z_0-9{]+(::[a-z_0-9]+)?|super::[A-Za-z_])' | sort -u | while read -r path; do
        path=${path#crate::reconstruct::}
        if [[ -f $room/${path/:://}.rs ]]; then echo "${name%.rs} ${path/:://}"; else echo "${name%.rs} ${path%%::*}"; fi
    done || true
done < <(find "$room" -name '*.rs' -not -name mod.rs))
while read -r file target; do
    folder=${file%%/*}
    [[ -f $room/$target.rs ]] || { breach "reconstruct/$file.rs imports from $target, not from the file that defines"; continue; }
    [[ ${target%%/*} == "$folder" || " ${uses[$folder]-} " == *" $target "* || " ${uses[$folder]-} " == *" ${target%%/*} "* ]] ||
        breach "reconstruct/$file.rs imports from $target"
done <<<"$imports"
while read -r hit; do breach "circle of imports in reconstruct: $hit"; done < <(tsort <<<"$imports" 2>&1 >/dev/null || true)

# 9. Inside load a room uses only what stands to its left here: first the files beside the rooms, then the rooms; a file imports from the
# file that defines, by its full path. No two files import each other.
room=$core/load
rooms=(names clocks formats maps guesses stream)
imports=$(while read -r file; do
    name=${file#"$room"/}
    name=${name%.rs}
    sed '/^#\[cfg(test)\]$/q' "$file" | grep -v '^ *//' | grep -oE 'crate::load::[a-z_0-9]+(::[a-z_0-9]+)?' | sort -u | while read -r path; do
        path=${path#crate::load::}
        if [[ -f $room/${path/:://}.rs ]]; then echo "${name%/mod} ${path/:://}"; else echo "${name%/mod} ${path%%::*}"; fi
    done || true
done < <(find "$room" -name '*.rs' -not -path "$room/mod.rs"))
while read -r file target; do
    from=${file%%/*} to=${target%%/*}
    for i in "${!rooms[@]}"; do
        [[ ${rooms[i]} == "$to" && " ${rooms[*]:i} " != *" $from "* ]] && breach "load/$file.rs uses $to: $target"
    done
done <<<"$imports"
while read -r hit; do breach "circle of imports in load: $hit"; done < <(tsort <<<"$imports" 2>&1 >/dev/null || true)

[[ $breaches -eq 0 ]] && echo "layer check: clean"
exit $breaches
