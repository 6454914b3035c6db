#!/usr/bin/env bash
# make_bill.sh FOLDER: software bills of materials (CycloneDX 1.5, JSON) of the program and of the Python package, for all systems they are
# built for. Needs cargo-cyclonedx (`cargo install --locked cargo-cyclonedx`). SOURCE_DATE_EPOCH dates them, so that two runs give the same bytes.
set -euo pipefail
mkdir -p "$1"
out=$(cd "$1" && pwd)
cd "$(dirname "$0")/.."
cargo cyclonedx --version >/dev/null 2>&1 || { echo "cargo-cyclonedx is missing: cargo install --locked cargo-cyclonedx"; exit 1; }
name=release-bill
# The tool writes beside every manifest of the workspace.
trap 'rm -f "$name.json" crates/*/"$name.json"' EXIT
cargo cyclonedx --quiet --format json --spec-version 1.5 --target all --override-filename "$name"
cp "$name.json" "$out/doublet.cdx.json"
cp "crates/python/$name.json" "$out/doublet-python.cdx.json"
python3 - "$out" <<'END'
import json, pathlib, sys
for file in sorted(pathlib.Path(sys.argv[1]).glob("*.cdx.json")):
    bill = json.loads(file.read_text(encoding="utf-8"))
    components = bill["components"]
    without = [one["name"] for one in components if not one.get("licenses")]
    print(f"{file.name}: {len(components)} components, {file.stat().st_size / 1000:.0f} kB, without a licence: {', '.join(without) or 'none'}")
END
