#!/usr/bin/env bash
# make_checksums.sh FOLDER: writes FOLDER/SHA256SUMS over its files. A release is a flat list of files: a folder in it is refused.
set -euo pipefail
cd "$1"
folders=$(find . -mindepth 1 -type d)
[[ -z $folders ]] || { echo "$1 contains folders: $folders"; exit 1; }
rm -f SHA256SUMS
files=$(find . -maxdepth 1 -type f -printf '%P\n' | LC_ALL=C sort)
[[ -n $files ]] || { echo "$1 is empty"; exit 1; }
tr '\n' '\0' <<<"$files" | xargs -0 sha256sum -- >SHA256SUMS.part
mv SHA256SUMS.part SHA256SUMS
sha256sum --check --quiet SHA256SUMS
echo "checksums of $(wc -l <SHA256SUMS) files"
