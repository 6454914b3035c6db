#!/usr/bin/env python3
"""Makes pages of the notebooks that nbconvert wrote without head and style, and a list of them: scripts/wrap_notebooks.py NOTEBOOKS PAGES."""
import html
import json
import pathlib
import sys

STYLE = """
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 sans-serif; color: #222; }
pre { overflow-x: auto; padding: .6rem; background: #f5f5f5; font-size: 14px; }
.prompt, .anchor-link { display: none; }
table { border-collapse: collapse; margin: .5rem 0; font-size: 14px; }
td, th { padding: .15rem .6rem; border-bottom: 1px solid #ddd; text-align: right; }
img, svg { max-width: 100%; }
"""


def page(title: str, body: str) -> str:
    head = f'<meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{html.escape(title)}</title><style>{STYLE}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n{body}\n</body></html>\n'


def title_of(notebook: pathlib.Path) -> str:
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    text = next("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")
    return text.splitlines()[0].lstrip("# ")


def main(notebooks: pathlib.Path, pages: pathlib.Path) -> None:
    rows = []
    for notebook in sorted(notebooks.glob("*.ipynb")):
        file = pages / f"{notebook.stem}.html"
        title = title_of(notebook)
        back = '<p><a href="index.html">Notebooks</a>, <a href="../index.html">manual</a></p>'
        file.write_text(page(title, back + "\n" + file.read_text(encoding="utf-8")), encoding="utf-8")
        rows.append(f'<li><a href="{file.name}">{html.escape(title)}</a></li>')
    body = f'<h1>Notebooks</h1>\n<ul>\n{"".join(rows)}\n</ul>\n<p><a href="../index.html">Manual</a></p>'
    (pages / "index.html").write_text(page("Notebooks", body), encoding="utf-8")
    print(f"notebooks: {len(rows)}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
