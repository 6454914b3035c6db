#!/usr/bin/env python3
"""Writes the source distribution of the Python package: scripts/make_sdist.py FOLDER.

maturin packs the crates only. The crates include files above them (assets/, sessions/ and the manual), which this script adds from the files
that git knows. SOURCE_DATE_EPOCH dates all entries. Needs maturin and git.
"""
import gzip
import io
import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
# What build scripts and `include_str!` of the crates read above them.
INCLUDED = ["assets", "sessions", ":(glob)docs/*.md", ":(glob)docs/reference/*.md", "LICENSE-MIT", "LICENSE-APACHE"]


def included() -> list[str]:
    listed = subprocess.run(["git", "ls-files", "-z", *INCLUDED], cwd=ROOT, check=True, capture_output=True, text=True)
    return sorted(path for path in listed.stdout.split("\0") if path)


def entry(name: str, content: bytes, mode: int, date: int) -> tuple[tarfile.TarInfo, bytes]:
    info = tarfile.TarInfo(name)
    info.size, info.mode, info.mtime = len(content), mode, date
    return info, content


def versions(lock: bytes) -> set[tuple[str, str]]:
    return {(one["name"], one["version"]) for one in tomllib.loads(lock.decode())["package"]}


def lock_without_workbench(packed: pathlib.Path, top: str) -> bytes:
    """The lock file of the crates in the archive, with the versions of the repository."""
    with tarfile.open(packed) as archive:
        archive.extractall(packed.parent, filter="data")
    tree = packed.parent / top
    there = (tree / "Cargo.lock").read_bytes()
    subprocess.run(["cargo", "update", "--workspace", "--quiet"], cwd=tree, check=True)
    lock = (tree / "Cargo.lock").read_bytes()
    if not versions(lock) <= versions(there):
        sys.exit(f"the lock file has other versions: {sorted(versions(lock) - versions(there))}")
    subprocess.run(["cargo", "metadata", "--locked", "--format-version", "1"], cwd=tree, check=True, stdout=subprocess.DEVNULL)
    return lock


def main(folder: pathlib.Path) -> None:
    date = int(os.environ.get("SOURCE_DATE_EPOCH", "0"))
    with tempfile.TemporaryDirectory() as work:
        subprocess.run(["maturin", "sdist", "--out", work], cwd=ROOT / "crates/python", check=True, stderr=subprocess.DEVNULL)
        (packed,) = pathlib.Path(work).glob("*.tar.gz")
        with tarfile.open(packed) as archive:
            members = [member for member in archive.getmembers() if member.isfile()]
            read = {one.name: (archive.extractfile(one).read(), one.mode & 0o755) for one in members}
        top = packed.name.removesuffix(".tar.gz")
        read[f"{top}/Cargo.lock"] = (lock_without_workbench(packed, top), 0o644)
    entries = [entry(name, content, mode, date) for name, (content, mode) in read.items()]
    there = {info.name for info, _ in entries}
    for path in included():
        name = f"{top}/{path}"
        if name not in there:
            entries.append(entry(name, (ROOT / path).read_bytes(), 0o644, date))
    entries.sort(key=lambda one: one[0].name)
    raw = io.BytesIO()
    with tarfile.open(fileobj=raw, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for info, content in entries:
            archive.addfile(info, io.BytesIO(content))
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / packed.name, "wb") as file, gzip.GzipFile("", "wb", mtime=date, fileobj=file) as compressed:
        compressed.write(raw.getvalue())
    print(f"{packed.name}: {len(entries)} files, {(folder / packed.name).stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
