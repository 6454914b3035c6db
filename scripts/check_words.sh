#!/usr/bin/env bash
# Holds what a command can hold of plain words: no forbidden form in a text a user can read. Texts are the string literals of the
# program and of the Python package, docstrings, the help of the command line, notebooks, the names of settings and the prose of pages of
# the manual. Needs bash, find and awk. `scripts/list_strings.py` has the same rules and counts them. Prints every breach; exit code 1 if
# there is one.
set -euo pipefail
cd "$(dirname "$0")/.."

# Path (beginning), form, reason. A form is that of the rules below.
allowed='
'
pages=(README.md CHANGELOG.md docs/*.md docs/reference/*.md docs/paper/*.md packaging/*.md crates/python/README.md
    src/panels/model/setting_words.txt)
python=(crates/python/python/doublet/*.py docs/notebooks/*.ipynb)

files=$(find src crates -name '*.rs' -not -path '*/tests/*' -not -path '*/benches/*' -not -path '*/examples/*' -not -name tests.rs | sort)
# shellcheck disable=SC2086
found=$(awk -v allowed="$allowed" '
function breach(rule) {
    for (k = 1; k <= exceptions; k++)
        if (index(FILENAME, place[k]) == 1 && form[k] == rule) return
    printf "word check: %s:%d %s: %s\n", FILENAME, first, rule, shown
}
# Words without numbers, units and lone signs; a name that is filled in is one.
function length_in_words(text,   n, all, k) {
    gsub(/\{[^{}]*:[^{}]*\}/, "0", text)
    gsub(/\{[^{}]*\}/, "name", text)
    gsub(/[()'"'"'"]+/, " ", text)
    gsub(/[.,:;]+( |$)/, " ", text)
    n = 0
    all = split(text, words, /[ ]+/)
    for (k = 1; k <= all; k++) if (words[k] ~ /[A-Za-z]/ && !(words[k] in units)) n++
    return n
}
# The longest part: what is wrong, and what to do, behind a colon or semicolon.
function longest_part(text,   all, parts, k, n, most) {
    all = split(text, parts, /[:;] /)
    for (k = 1; k <= all; k++) { n = length_in_words(parts[k]); if (n > most) most = n }
    return most
}
function check(text,   t) {
    shown = text
    if (is_help && length_in_words(text) > 12) breach("help over 12 words")
    if (FILENAME ~ /engine\/src\/verdict\// && length_in_words(text) > 15) breach("finding over 15 words")
    if (FILENAME ~ /(engine\/src\/(stage|study|session)|core\/src\/compatibility)\// && longest_part(text) > 15) breach("part of a finding over 15 words")
    gsub(/\{[^{}]*\}/, "{}", text)
    gsub(/\\[nt"]/, " ", text)
    t = tolower(text)
    if (split(t, words, /[ ]+/) < 4) return
    gsub(/[.,:;!?()'"'"'"]+/, " & ", t)
    gsub(/[ ]+/, " ", t)
    t = " " t " "
    gsub(/ (is|are) no (more|less|longer|later|earlier|larger|smaller|better|worse) /, " ", t)
    gsub(/ stands? (for|alone|still|on) /, " ", t)
    if (t ~ / (is|are|was|were) no /) breach("is no")
    if (t ~ / none (is|are|was|were) /) breach("none is")
    if (t ~ / nobody /) breach("nobody")
    if (t ~ / nothing (but|else) /) breach("nothing but")
    if (t ~ / (tell|tells|told) /) breach("tell")
    if (t ~ / by (itself|themselves) /) breach("by itself")
    if (t ~ / as [a-z]+ as may be /) breach("as well as may be")
    if (t ~ / hangs? together /) breach("hang together")
    if (t ~ / (stand|stands|stood) /) breach("stands")
    if (t ~ / (is|are|was|were|be|being) (said|asked|wanted|believed|meant) / || t ~ / may be believed /) breach("is said")
    if (t ~ / in (the|its|their) place /) breach("in the place of")
    if (t ~ /^ "?what [a-z]+ / && t !~ /\?/) breach("what-clause")
    if (t ~ / (mend|mends|mended|mending) /) breach("mend")
    if (t ~ / flown again /) breach("flown again")
    if (t ~ / (borrow|borrows|borrowed|lend|lends) /) breach("lend and borrow")
    if (t ~ / to and fro / || t ~ / turned over /) breach("to and fro")
    if (t ~ / cures? /) breach("cure")
    if (t ~ / anew / || t ~ / called so /) breach("anew")
    if (t ~ / (hold|holds|held) the truth / || t ~ / speaks? for /) breach("hold the truth")
    if (t ~ / (data|channels?|samples?|manoeuvres?|windows?|sensors?|recordings?|filters?|files?) (say|says|know|knows|feel|feels|believe|believes|ask|asks|want|wants) /) breach("personified")
}
BEGIN {
    count = split("s m deg rad Pa kg m2 m/s m/s2 deg/s rad/s Hz ms kt ft", names, " ")
    for (k = 1; k <= count; k++) units[names[k]] = 1
    count = split(allowed, lines, "\n")
    for (k = 1; k <= count; k++)
        if (split(lines[k], part, "|") == 3) { exceptions++; place[exceptions] = part[1]; form[exceptions] = part[2] }
}
FNR == 1 { in_text = 0; raw = ""; in_tests = 0; is_help = 0; is_code = 0; comment = 0; last = "" }
# Prose: not in blocks of code, not what is quoted as code.
FILENAME ~ /\.(md|txt)$/ {
    if ($0 ~ /^```/) { is_code = !is_code; next }
    if (is_code || $0 ~ /^    / || $0 ~ /^<!--/) next
    first = FNR
    line = $0
    gsub(/`[^`]*`/, "x", line)
    gsub(/\]\([^)]*\)/, "]", line)
    gsub(/[*_#|]/, " ", line)
    check(line)
    next
}
# Python: docstrings line by line, other strings of one line; without what is quoted as code.
FILENAME ~ /\.py$/ {
    first = FNR
    line = $0
    gsub(/`+[^`]*`+/, "x", line)
    while (line != "") {
        if (in_text) {
            at = index(line, raw)
            check(at ? substr(line, 1, at - 1) : line)
            if (!at) next
            line = substr(line, at + 3)
            in_text = 0; raw = ""
        } else if (match(line, /"""|"([^"\\]|\\.)*"|'"'"'([^'"'"'\\]|\\.)*'"'"'|#/)) {
            token = substr(line, RSTART, RLENGTH)
            line = substr(line, RSTART + RLENGTH)
            if (token == "#") next
            if (token == "\"\"\"") { in_text = 1; raw = token } else check(substr(token, 2, length(token) - 2))
        } else next
    }
    next
}
# A notebook: prose and code of its cells, not what they printed.
FILENAME ~ /\.ipynb$/ {
    if ($0 ~ /^ *"source": \[/) { is_code = 1; next }
    if (is_code && $0 ~ /^ *\],?$/) is_code = 0
    if (!is_code) next
    first = FNR
    line = $0
    sub(/^ *"/, "", line)
    sub(/(\\n)?",?$/, "", line)
    gsub(/`[^`]*`/, "x", line)
    gsub(/\]\([^)]*\)/, "]", line)
    gsub(/[*_#|]/, " ", line)
    check(line)
    next
}
in_tests { next }
{ line = $0 }
# Unit tests end a file.
!in_text && line ~ /^#\[cfg\(test\)\]/ { last = line; next }
last != "" { if (line ~ /^mod [a-z_]+ \{/) in_tests = 1; last = ""; if (in_tests) next }
# Help texts: doc comments of the types that clap reads, and of the table of commands.
FILENAME ~ /^crates\/cli\// && line ~ /^#\[derive\(/ { is_help = line ~ /(Parser|Args|Subcommand|ValueEnum)/ }
FILENAME ~ /^crates\/cli\// && line ~ /^commands! \{/ { is_help = 1 }
FILENAME ~ /^crates\/cli\// && line ~ /^}/ { is_help = 0 }
!in_text && is_help && line ~ /^ *\/\/\/ / {
    help = line
    sub(/^ *\/\/\/ /, "", help)
    first = FNR
    check(help)
    next
}
{
    while (1) {
        if (in_text && raw != "") {
            at = index(line, raw)
            if (!at) { text = text line " "; break }
            text = text substr(line, 1, at - 1)
            line = substr(line, at + length(raw))
            in_text = 0; raw = ""
            check(text)
        } else if (in_text) {
            if (match(line, /^([^"\\]|\\.)*"/)) {
                text = text substr(line, 1, RLENGTH - 1)
                line = substr(line, RLENGTH + 1)
                in_text = 0
                if (!is_reason) check(text)
            } else {
                sub(/^ +/, "", line)
                if (line ~ /\\$/) line = substr(line, 1, length(line) - 1); else line = line " "
                text = text line
                break
            }
        } else if (match(line, /\/\/|r#*"|"|'"'"'([^'"'"'\\]|\\.[^'"'"']*)'"'"'/)) {
            token = substr(line, RSTART, RLENGTH)
            before = substr(line, 1, RSTART - 1)
            line = substr(line, RSTART + RLENGTH)
            if (token == "//") break
            if (token ~ /"$/) {
                in_text = 1; text = ""; first = FNR
                is_reason = before ~ /reason = $/
                if (token ~ /^r/) { raw = token; sub(/^r/, "", raw); raw = "\"" substr(raw, 1, length(raw) - 1) }
                # The rest of a line behind the opening quote has no indentation to take away.
                if (raw == "" && !match(line, /^([^"\\]|\\.)*"/)) {
                    if (line ~ /\\$/) line = substr(line, 1, length(line) - 1); else line = line " "
                    text = line
                    break
                }
            }
        } else break
    }
}' $files "${pages[@]}" "${python[@]}")
# A chapter begins with what its reader can do after it.
for page in docs/*.md; do
    case $page in */SUMMARY.md | */introduction.md) continue ;; esac
    if ! grep -q '^After this chapter you can ' "$page"; then
        found+=${found:+$'\n'}"word check: $page: no beginning: After this chapter you can ..."
    fi
done
if [[ -n $found ]]; then
    printf '%s\n' "$found"
    exit 1
fi
echo "word check: clean"
