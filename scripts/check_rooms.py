#!/usr/bin/env python3
"""Order of the rooms of every crate: the folders and files directly below `src`. A room uses only rooms that stand before it in
ORDER. Prints every arrow that goes the wrong way and every room without a place; exit code 1 if there is one.
`scripts/check_rooms.py --knots` prints rooms, arrows and knots of each crate instead."""

import re
import sys
from collections import defaultdict
from pathlib import Path

ORDER = {
    "crates/core/src": """quantity schema message toml_error statistics series optimise decompose atmos airframe propulsion motion load align prep compatibility
        reconstruct model replay estimate validate sensitivity simulate""",
    "crates/dynamics/src": "propagate linear frequency modes design qualities",
    "crates/fmu/src": "unsupported variables instance interface",
    "crates/engine/src": """date notation keep toml_file builtin graph session autosave undo trace calibrate stage begin study live prior snapshot
        verdict report compare planning run check aircraft confidence recorded_coverage batch document export qtg weigh ground_tests""",
    "crates/report/src": "library svg html pdf",
    "crates/cli/src": """outcome output_path pages questions role_option search suggest table text version aircraft check equations glossary live progress
        propose regress schema shell summary thesis time_option weigh swing batch manual map run simulate tune compare compatibility
        diff dynamics export fix match_command new propagate structure variants arguments datcom debrief engine fmu inspect static_thrust
        response study campaign design lags prior qtg coverage report fidelity""",
    "src": "step theme notation widgets pane command layouts ui_state panels app",
}


def product_code(text):
    """The code of a file without comments and without its tests at the end."""
    tests = re.search(r"^#\[cfg\(test\)\]\s*\n(?:pub\S* )?mod ", text, re.M)
    return re.sub(r"//[^\n]*", "", text[: tests.start()] if tests else text)


def expand(path):
    """The paths that `a::{b, c::{d}}` names."""
    head, brace, rest = path.partition("{")
    if not brace:
        return [path.strip()]
    parts, depth, part = [], 0, ""
    for letter in rest[: rest.rindex("}")] + ",":
        if letter == "," and depth == 0:
            parts.append(part.strip())
            part = ""
        else:
            depth += {"{": 1, "}": -1}.get(letter, 0)
            part += letter
    return [head + name for part in parts if part for name in expand(part)]


def arrows(root):
    """The rooms below `root`, and for each pair the places where the first uses the second."""
    files = [file for file in sorted(root.rglob("*.rs")) if file.parent != root or file.stem not in ("lib", "main")]
    rooms = {file.relative_to(root).parts[0].removesuffix(".rs") for file in files}
    uses = defaultdict(list)
    for file in files:
        room = file.relative_to(root).parts[0].removesuffix(".rs")
        code = product_code(file.read_text())
        paths = [path for use in re.findall(r"\buse\s+(crate::[^;]+);", code) for path in expand(use)]
        paths += re.findall(r"(?<![\w$])crate::\w+", re.sub(r"\buse\s+crate::[^;]+;", "", code))
        for path in paths:
            used = path.split("::")[1]
            if used in rooms and used != room:
                uses[room, used].append(f"{file}: {path}")
    return rooms, uses


def knots(rooms, uses):
    """Sets of rooms that reach each other."""
    reach = {room: {used for user, used in uses if user == room} for room in rooms}
    for between in rooms:
        for room in rooms:
            if between in reach[room]:
                reach[room] |= reach[between]
    found = {frozenset(other for other in reach[room] if room in reach[other]) for room in rooms}
    return sorted((sorted(knot) for knot in found if len(knot) > 1), key=len)


def main():
    breaches = []
    for place, order in ORDER.items():
        rooms, uses = arrows(Path(place))
        if "--knots" in sys.argv:
            print(f"{place}: {len(rooms)} rooms, {len(uses)} arrows, knots: {knots(rooms, uses) or 'none'}")
            continue
        levels = {room: level for level, room in enumerate(order.split())}
        breaches += [f"{place}/{room} has no place in ORDER" for room in sorted(rooms - levels.keys())]
        for (user, used), places in sorted(uses.items()):
            if levels.get(user, 0) < levels.get(used, 0):
                breaches += [f"{user} uses {used}: {found}" for found in places]
    if breaches:
        sys.exit("\n".join(breaches))


if __name__ == "__main__":
    main()
