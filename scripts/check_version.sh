#!/usr/bin/env bash
# check_version.sh TAG: the tag is v and the version, which Cargo.toml, packaging/packager.toml, CITATION.cff and the conda recipe state alike.
set -euo pipefail
cd "$(dirname "$0")/.."
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
status=0
expect() {
    if [[ $2 != "$3" ]]; then
        echo "$1 states '$2', expected '$3'"
        status=1
    fi
}
[[ $# -eq 0 ]] || expect "the tag" "$1" "v$version"
expect packaging/packager.toml "$(sed -n 's/^version = "\(.*\)"/\1/p' packaging/packager.toml)" "$version"
expect CITATION.cff "$(sed -n 's/^version: *"\{0,1\}\([^"]*\)"\{0,1\}$/\1/p' CITATION.cff)" "$version"
expect packaging/conda/recipe.yaml "$(sed -n 's/^  version: "\(.*\)"/\1/p' packaging/conda/recipe.yaml)" "$version"
((status)) || echo "version: $version everywhere"
exit $status
