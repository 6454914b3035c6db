"""Lays out the tree of the Debian package by the table in Cargo.toml: python3 scripts/assemble_deb.py BINARY TREE."""

import glob
import gzip
import json
import os
import pathlib
import shutil
import subprocess
import sys


def main(binary: str, tree: str) -> None:
    metadata = json.loads(subprocess.check_output(["cargo", "metadata", "--no-deps", "--format-version", "1"]))
    package = next(p for p in metadata["packages"] if p["name"] == "doublet")
    deb = package["metadata"]["deb"]
    root = pathlib.Path(tree)
    for source, target, mode in deb["assets"]:
        is_program = source == "target/release/doublet"
        found = [binary] if is_program else sorted(glob.glob(source))
        for path in found or sys.exit(f"{source} is not there"):
            name = "doublet" if is_program else os.path.basename(path)
            place = root / target / name if target.endswith("/") else root / target
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, place)
            place.chmod(int(mode, 8))
            if place.suffix == ".1":
                with gzip.GzipFile(f"{place}.gz", "wb", mtime=0) as packed:
                    packed.write(place.read_bytes())
                place.unlink()
    size = sum(path.stat().st_size for path in root.rglob("*") if path.is_file()) // 1024
    architecture = subprocess.check_output(["dpkg", "--print-architecture"], text=True).strip()
    description = "\n".join(f" {line}" for line in deb["extended-description"].splitlines())
    control = root / "DEBIAN" / "control"
    control.parent.mkdir()
    control.write_text(
        f"Package: doublet\nVersion: {package['version']}-1\nArchitecture: {architecture}\nMaintainer: {deb['maintainer']}\n"
        f"Installed-Size: {size}\nDepends: {deb['depends']}\nRecommends: {deb['recommends']}\nSection: {deb['section']}\n"
        f"Priority: {deb['priority']}\nDescription: {package['description']}\n{description}\n"
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
