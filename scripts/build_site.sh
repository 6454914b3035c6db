#!/usr/bin/env bash
# Builds the manual as a static site in target/book: all pages by mdBook, and the notebooks, executed, below notebooks/. It needs no network to
# be read. Needs mdbook (`cargo install --locked mdbook`); for the notebooks jupyter-nbconvert and a Python with the package doublet.
# SITE_NOTEBOOKS=0 leaves the notebooks out. Exit code 1 if the site is not whole.
set -euo pipefail
cd "$(dirname "$0")/.."
out=target/book
command -v mdbook >/dev/null || { echo "mdbook is missing: cargo install --locked mdbook"; exit 1; }
mdbook build docs
# Sources and tables of other tools are not pages.
rm -rf "$out/paper" "$out/book.toml"
if [[ ${SITE_NOTEBOOKS:-1} != 0 ]]; then
    command -v jupyter-nbconvert >/dev/null || { echo "jupyter-nbconvert is missing: pip install nbconvert ipykernel"; exit 1; }
    python3 -c 'import doublet' 2>/dev/null || { echo "the package doublet is missing: pip install './crates/python[all]'"; exit 1; }
    mkdir -p "$out/notebooks"
    # A notebook writes its files beside itself.
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    cp docs/notebooks/*.ipynb "$work"
    for notebook in "$work"/*.ipynb; do
        # The template without scripts and styles from a network; the page around it is made below.
        MPLBACKEND=module://matplotlib_inline.backend_inline jupyter-nbconvert --log-level ERROR --to html --template basic --execute \
            --output-dir "$PWD/$out/notebooks" "$notebook"
    done
    python3 scripts/wrap_notebooks.py docs/notebooks "$out/notebooks"
else
    echo "left out: notebooks (SITE_NOTEBOOKS=0)"
fi
if grep -rlE --include='*.html' '(src|href)="(https?:)?//[^"]*\.(js|css|woff2?)"' "$out" || grep -rlI 'MathJax\.js' "$out" --include='*.html'; then
    echo "these pages load something from a network"
    exit 1
fi
if grep -rlF --include='*.html' '{{#include' "$out"; then
    echo "these pages show an include line"
    exit 1
fi
echo "site: $out/index.html, $(find "$out" -name '*.html' | wc -l) pages, $(du -sm "$out" | cut -f1) MB"
