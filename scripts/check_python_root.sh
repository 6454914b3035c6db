#!/usr/bin/env bash
# Runs the package of an environment in a root that has nothing but Python, NumPy, doublet and the libraries they load: no shell, no compiler,
# no /proc, no network. check_python_root.sh ENVIRONMENT. Needs a system that lets the user make namespaces; elsewhere it says so.
set -euo pipefail
environment=$(realpath "$1")
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
apart=("$(command -v unshare)" --user --map-root-user --mount --net --pid --fork)
PATH=$PATH:/usr/sbin:/sbin
changed=$(command -v chroot)
"${apart[@]}" true 2>/dev/null || { echo "bare root: left out, this system does not allow namespaces"; exit 0; }
mapfile -t places < <("$environment/bin/python" - <<'END'
import os, sys, sysconfig
print(os.path.realpath(sys.executable), sysconfig.get_path("stdlib"), sysconfig.get_path("purelib"), sep="\n")
END
)
program=${places[0]} library=${places[1]} packages=${places[2]}
copied() { mkdir -p "$root$(dirname "$1")" && cp -rL "$1" "$root$1"; }
copied "$program"
copied "$library"
rm -rf "${root:?}$library"/{test,idlelib,site-packages,dist-packages,ensurepip}
mkdir -p "$root/packages" "$root/tmp"
cp -r "$packages"/numpy "$packages"/numpy.libs "$packages"/doublet "$root/packages/"
# What the loader finds for the program and its extensions, and the loader itself.
{ echo "$program"; find "$root$library" "$root/packages" -name '*.so*' -type f; } | { xargs ldd 2>/dev/null || true; } |
    grep -o '/[^ ]*\.so[^ ]*' | sort -u | while read -r file; do
        [[ $file == "$root"* || ! -f $file ]] || copied "$file"
    done
printf '%s\n' "bare root: $(find "$root" -name '*.so*' -type f | wc -l) libraries, $(du -sm "$root" | cut -f1) MB"
env -i PYTHONHOME="$("$environment/bin/python" -c 'import sys; print(sys.base_prefix)')" PYTHONPATH=/packages "${apart[@]}" "$changed" "$root" "$program" -c '
import os
assert os.listdir("/tmp") == [] and not os.path.exists("/proc") and not os.path.exists("/bin/sh")
import doublet as db
results = db.run(db.Session.load("builtin:demo"))
if os.fork() == 0:
    again = db.run(db.Session.load("builtin:demo"))
    os._exit(0 if again.derivatives == results.derivatives else 1)
assert os.waitstatus_to_exitcode(os.wait()[1]) == 0
path = db.reconstruct(results.recording(), db.aircraft("c337f"), windows=db.Session.load("builtin:demo").windows[:2])
print(f"bare root: verdict {results.verdict.level}, the same after a fork, {len(path)} paths")'
