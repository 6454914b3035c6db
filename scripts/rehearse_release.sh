#!/usr/bin/env bash
# Runs what can be run of a release without the hosting service: versions, workflows and the conda recipe read, icons, source distribution,
# bills of materials, checksums over a layout like that of the release, site. Each part that lacks its tool is named at the end and does not
# count as run. Exit code 1 if a part fails. REHEARSE_WHEEL=1 also builds the wheel (minutes), DOUBLET_BINARY=FILE also packs a .deb of that
# program.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-target/rehearsal}
rm -rf "$out"
mkdir -p "$out/release"
out=$(realpath "$out")
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
missing=() failed=()
python=${PYTHON:-python3}

# part NAME COMMAND...: runs it and keeps its output.
part() {
    local name=$1
    shift
    # In a condition the shell would go on behind a command that fails.
    set +e
    (
        set -e
        "$@"
    ) >"$out/log" 2>&1
    local status=$?
    set -e
    if ((status == 0)); then
        echo "$name: $(tail -1 "$out/log")"
    else
        failed+=("$name")
        echo "$name: FAILED"
        sed 's/^/    /' "$out/log"
    fi
}
needs() { missing+=("$1 (needs $2)"); }
has_module() { "$python" -c "import $1" 2>/dev/null; }

workflows() {
    "$python" - <<'END'
import pathlib, re, yaml
count = 0
for file in sorted(pathlib.Path(".github/workflows").glob("*.yml")):
    jobs = yaml.safe_load(file.read_text())["jobs"]
    for name, job in jobs.items():
        assert set(job.get("needs", []) if isinstance(job.get("needs", []), list) else [job["needs"]]) <= set(jobs), (file, name)
        for step in job["steps"]:
            count += 1
            assert ("uses" in step) != ("run" in step), (file, name, step)
            for script in re.findall(r"scripts/[a-z_]+\.(?:sh|py)", step.get("run", "")):
                assert pathlib.Path(script).is_file(), (file, name, script)
    assert not re.search(r"macos-1[0-4]\b", file.read_text()), f"{file}: retired runner"
print(f"{count} steps, every script of theirs is there")
END
}
packager() {
    "$python" - <<'END'
import glob, os, tomllib
config = tomllib.load(open("packaging/packager.toml", "rb"))
os.chdir("packaging")
icons = [path for pattern in config["icons"] for path in glob.glob(pattern)]
endings = {os.path.splitext(path)[1] for path in icons}
assert endings == {".png", ".icns", ".ico"}, endings
for path in [config["licenseFile"], config["nsis"]["installerIcon"]]:
    assert os.path.exists(path), path
print(f"{len(icons)} icons, licence and paths are there")
END
}
recipe() {
    "$python" - <<'END'
import pathlib, tomllib, yaml
recipe = yaml.safe_load(open("packaging/conda/recipe.yaml"))
package = tomllib.load(open("crates/python/pyproject.toml", "rb"))
without_spaces = lambda rows: {row.replace(" ", "") for row in rows}
assert package["project"]["requires-python"] == f">={recipe['context']['python_min']}"
assert set(package["project"]["dependencies"]) <= without_spaces(recipe["requirements"]["run"])
assert set(package["build-system"]["requires"]) <= without_spaces(recipe["requirements"]["host"])
assert recipe["about"]["license"] == package["project"]["license"]
licences = recipe["about"]["license_file"]
made = " ".join(recipe["build"]["script"])
assert all(pathlib.Path(name).is_file() or name in made for name in licences), licences
assert recipe["build"]["python"]["version_independent"] and any(row.startswith("python-abi3") for row in recipe["requirements"]["host"])
print("Python, NumPy, maturin and licence are those of the package")
END
}
source_distribution() {
    "$python" scripts/make_sdist.py "$out/once" && "$python" scripts/make_sdist.py "$out/twice"
    cmp "$out"/once/*.tar.gz "$out"/twice/*.tar.gz
    cp "$out"/once/*.tar.gz "$out/release/"
    # Everything that the crates include from above themselves is in it.
    mkdir "$out/unpacked"
    tar xzf "$out"/once/*.tar.gz -C "$out/unpacked" --strip-components 1
    local file
    for file in docs/SUMMARY.md docs/glossary.md docs/reference/commands.md assets/aircraft/c337f.toml sessions/demo.toml; do
        cmp "$file" "$out/unpacked/$file"
    done
    ls "$out/release"/*.tar.gz | xargs -n 1 basename
}
bills() {
    scripts/make_bill.sh "$out/bill" && scripts/make_bill.sh "$out/bill2"
    diff -r "$out/bill" "$out/bill2"
    cp "$out"/bill/*.cdx.json "$out/release/"
    git diff --quiet --exit-code || { echo "the bill left files or changes in the checkout"; return 1; }
    echo "$(cat "$out"/bill/*.json | wc -c) bytes, equal in two runs"
}
wheel() {
    (cd crates/python && CARGO_TARGET_DIR=../../target/python maturin build --release --locked --out "$out/release")
    ls "$out"/release/*.whl | xargs -n 1 basename
}
debian() {
    DEB_COMPRESSION=none scripts/check_deb.sh
}
checksums() {
    # Files of the kinds that only their own systems make, by name, so that the layout is that of the release.
    local name
    for name in doublet_0.1.0_x86_64.AppImage doublet_0.1.0_x64-setup.exe doublet_0.1.0_aarch64.dmg; do
        echo "placeholder of the rehearsal" >"$out/release/$name"
    done
    scripts/make_checksums.sh "$out/release"
    (cd "$out/release" && sha256sum --check --quiet SHA256SUMS)
    mkdir "$out/release/doublet.app"
    if scripts/make_checksums.sh "$out/release" >/dev/null; then
        echo "a folder was taken for a file"
        return 1
    fi
    rmdir "$out/release/doublet.app"
    echo "$(wc -l <"$out/release/SHA256SUMS") files; a folder among them is refused"
}

part versions scripts/check_version.sh
if has_module yaml; then part workflows workflows; else needs workflows "pip install pyyaml"; fi
part packager packager
if has_module yaml; then part recipe recipe; else needs recipe "pip install pyyaml"; fi
if has_module PIL; then part icons "$python" scripts/make_icons.py --check; else needs icons "pip install pillow"; fi
if command -v maturin >/dev/null; then part source source_distribution; else needs source "pip install maturin"; fi
if command -v twine >/dev/null && compgen -G "$out/release/*.tar.gz" >/dev/null; then
    part metadata twine check --strict "$out"/release/*.tar.gz
else
    needs metadata "pip install twine, and the source distribution"
fi
if cargo cyclonedx --version >/dev/null 2>&1; then part bills bills; else needs bills "cargo install --locked cargo-cyclonedx"; fi
if [[ ${REHEARSE_WHEEL:-} == 1 ]]; then part wheel wheel; else needs wheel "REHEARSE_WHEEL=1"; fi
if [[ -n ${DOUBLET_BINARY:-} ]]; then part debian debian; else needs debian "DOUBLET_BINARY=FILE"; fi
part checksums checksums
for one in "${missing[@]}"; do echo "not run: $one"; done
echo "not run: AppImage, Windows installer, disk image, attestations, upload (need the hosting service)"
[[ ${#failed[@]} -eq 0 ]] || { echo "failed: ${failed[*]}"; exit 1; }
