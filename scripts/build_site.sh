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
if grep -rlE --include='*.html' '(src|href)="(https?:)?//[^"]*\.(js|css|woff2?)"' "$out" || grep -rlI 'MathJax\.js' "$out" --include='*.html'; then
    echo "these pages load something from a network"
    exit 1
fi
if [[ ${SITE_NOTEBOOKS:-1} != 0 ]]; then
    command -v jupyter-nbconvert >/dev/null || { echo "jupyter-nbconvert is missing: pip install nbconvert ipykernel"; exit 1; }
    python3 -c 'import doublet' 2>/dev/null || { echo "the package doublet is missing: pip install './crates/python[all]'"; exit 1; }
    for notebook in docs/notebooks/*.ipynb; do
        MPLBACKEND=module://matplotlib_inline.backend_inline jupyter-nbconvert --to html --execute --output-dir "$out/notebooks" "$notebook"
    done
    rm -f "$out"/notebooks/*.ipynb
    python3 - "$out" <<'END'
import json, pathlib, sys
def title(file):
    first = next(cell for cell in json.loads(file.read_text())["cells"] if cell["cell_type"] == "markdown")
    return "".join(first["source"]).splitlines()[0].lstrip("# ")
rows = [f'<li><a href="{file.stem}.html">{title(file)}</a></li>' for file in sorted(pathlib.Path("docs/notebooks").glob("*.ipynb"))]
page = f'<!doctype html><meta charset="utf-8"><title>Notebooks</title><h1>Notebooks</h1><ul>{"".join(rows)}</ul><a href="../index.html">Manual</a>'
pathlib.Path(sys.argv[1], "notebooks", "index.html").write_text(page)
END
else
    echo "left out: notebooks (SITE_NOTEBOOKS=0)"
fi
echo "site: $out/index.html, $(find "$out" -name '*.html' | wc -l) pages, $(du -sm "$out" | cut -f1) MB"
