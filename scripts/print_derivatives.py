"""Six pooled derivatives of a results.json on one line: python3 scripts/print_derivatives.py RESULTS."""

import json
import sys

NAMES = ["Cl_p", "Cl_delta_a", "Cm_alpha", "Cm_delta_e", "Cn_beta", "Cn_delta_r"]


def collect(node: object, found: dict[str, float]) -> None:
    """Takes the first estimate of every name below a node."""
    if isinstance(node, dict):
        if "name" in node and "estimate" in node:
            found.setdefault(node["name"], node["estimate"])
        node = list(node.values())
    if isinstance(node, list):
        for value in node:
            collect(value, found)


with open(sys.argv[1], encoding="utf-8") as file:
    results = json.load(file)
estimates: dict[str, float] = {}
collect(results.get("pooled", results), estimates)
print("  ".join(f"{estimates[name]:.4g}" if name in estimates else "none" for name in NAMES))
