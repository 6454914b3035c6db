#!/usr/bin/env python3
"""Writes the types of `doublet.commands` from the table of the command line: crates/python/python/doublet/commands.pyi.

Needs the package of this checkout in the Python that runs it. Run it when a command or an argument has changed; a test compares.
"""

import pathlib
import textwrap

from doublet._commands import parameters, python_name, table

STUB = pathlib.Path(__file__).resolve().parent.parent / "crates" / "python" / "python" / "doublet" / "commands.pyi"
HEAD = '''"""One function for each command of the command line. Written by scripts/python_commands.py."""

from typing import Literal, Optional

from ._commands import Answer, Input, Many

'''


def kind(row: dict) -> str:
    """Type of an argument."""
    if not row["takes_value"]:
        return "bool"
    one = f"Literal[{', '.join(f'{choice!r}' for choice in row['choices'])}]".replace("'", '"') if row["choices"] else "Input"
    one = "Many" if row["repeats"] else one
    return one if row["required"] else f"Optional[{one}]"


def signature(row: dict) -> str:
    """The function of a command."""
    parts, starred = [], False
    for name, one in parameters(row):
        if one["long"] is not None and not starred:
            parts.append("*")
            starred = True
        parts.append(f"{name}: {kind(one)}" + ("" if one["required"] else " = ..."))
    name = python_name("_".join(row["name"]))
    line = f"def {name}({', '.join(parts)}) -> Answer: ..."
    if len(line) <= 132:
        return line
    inner = textwrap.fill(", ".join(parts), 128, initial_indent="    ", subsequent_indent="    ", break_long_words=False)
    return f"def {name}(\n{inner},\n) -> Answer: ..."


def stub() -> str:
    """The whole file."""
    rows = table()
    names = sorted(python_name("_".join(row["name"])) for row in rows)
    exported = textwrap.fill(", ".join(f'"{name}"' for name in ["Answer", *names]), 128, initial_indent="    ", subsequent_indent="    ")
    return HEAD + f"__all__ = [\n{exported},\n]\n\n" + "\n".join(signature(row) for row in rows) + "\n"


if __name__ == "__main__":
    STUB.write_text(stub(), encoding="utf-8")
