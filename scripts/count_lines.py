#!/usr/bin/env python3
"""Counts lines of Rust by room: code, documentation, other comments, blank lines and tests.

    scripts/count_lines.py             by crate
    scripts/count_lines.py --rooms     by folder below the sources of each crate

Tests are files below `tests` or `benches`, what follows `#[cfg(test)]` at the end of a file, and the files of modules that are compiled
for tests alone.
"""
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
KINDS = ["code", "documentation", "comments", "blank", "tests"]


def is_test_module(path):
    """Whether a file is a module that the one above it compiles for tests alone."""
    above = [path.parent / "mod.rs", path.parent.with_suffix(".rs")]
    declared = re.compile(rf"^#\[cfg\(test\)\]\nmod {path.stem};", re.MULTILINE)
    return any(file.is_file() and declared.search(file.read_text(encoding="utf-8")) for file in above)


def count(path):
    """Lines of a file by kind."""
    lines = path.read_text(encoding="utf-8").splitlines()
    found = collections.Counter()
    if {"tests", "benches"} & set(path.relative_to(ROOT).parts) or is_test_module(path):
        found["tests"] = len(lines)
        return found
    is_test = False
    for index, line in enumerate(lines):
        text = line.strip()
        following = lines[index + 1].strip() if index + 1 < len(lines) else ""
        is_test |= line.startswith("#[cfg(test)]") and re.match(r"mod \w+ \{", following) is not None
        if is_test:
            found["tests"] += 1
        elif not text:
            found["blank"] += 1
        elif text.startswith(("///", "//!")):
            found["documentation"] += 1
        elif text.startswith("//"):
            found["comments"] += 1
        else:
            found["code"] += 1
    return found


def room_of(path, is_by_room):
    """The crate of a file, or the folder below its sources."""
    parts = path.relative_to(ROOT).parts
    crate = 2 if parts[0] == "crates" else 1
    if not is_by_room:
        return "/".join(parts[:crate])
    folder = parts[:-1]
    return "/".join(folder[: crate + 2 if parts[0] == "crates" else 2])


def main():
    is_by_room = "--rooms" in sys.argv
    rooms = collections.defaultdict(collections.Counter)
    folders = ["src", "crates", "tests", "fuzz"]
    files = [path for folder in folders for path in (ROOT / folder).rglob("*.rs") if "target" not in path.parts]
    for path in files:
        rooms[room_of(path, is_by_room)] += count(path) + collections.Counter(files=1)
    total = sum(rooms.values(), collections.Counter())
    width = max(map(len, rooms))
    print(f"{'':{width}} {'files':>6} " + " ".join(f"{kind:>13}" for kind in KINDS))
    for room, found in [*sorted(rooms.items()), ("all", total)]:
        print(f"{room:{width}} {found['files']:>6} " + " ".join(f"{found[kind]:>13}" for kind in KINDS))


if __name__ == "__main__":
    main()
