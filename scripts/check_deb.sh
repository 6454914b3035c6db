#!/usr/bin/env bash
# Builds the Debian package, installs it into an empty root, runs the program there with nothing but what the package depends on, and
# removes it again: nothing may stay. Needs dpkg-deb and Python 3; cargo-deb builds the package where it is installed, else dpkg-deb from
# the same table in Cargo.toml. DOUBLET_DEB names a package that is built already, DOUBLET_BINARY a binary to package instead of one of the
# profile dist; DEB_COMPRESSION=none packs quickly.
#
# With debootstrap and root rights the empty root is a minimal Debian (DEBIAN_SUITE, by default bookworm), in which apt resolves the
# dependencies; then the recommended libraries are installed, and a session is opened by its file type under a virtual display.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)

deb=$work/doublet.deb
if [[ -n ${DOUBLET_DEB:-} ]]; then
    cp "$DOUBLET_DEB" "$deb"
    dpkg-deb --extract "$deb" "$work/unpacked"
    binary=$work/unpacked/usr/bin/doublet
else
    binary=${DOUBLET_BINARY:-target/dist/doublet}
    # The linker that comes with rustc on x86-64 keeps one of equal functions; a build with that flag is not done again.
    if [[ $(uname -m) == x86_64 && ${RUSTFLAGS:-} != *--icf=all* ]]; then
        export RUSTFLAGS="${RUSTFLAGS:-} -Clink-arg=-Wl,--icf=all"
    fi
    [[ -n ${DOUBLET_BINARY:-} ]] || cargo build --locked --profile dist --bin doublet
    mkdir -p target/package/man
    "$binary" man --out target/package/man >/dev/null
    "$binary" completions bash >target/package/doublet.bash
    if [[ -z ${DOUBLET_BINARY:-} ]] && cargo deb --version >/dev/null 2>&1; then
        cargo deb --profile dist --no-build --output "$deb"
    else
        python3 scripts/assemble_deb.py "$binary" "$work/tree"
        dpkg-deb "-Z${DEB_COMPRESSION:-xz}" --root-owner-group --build "$work/tree" "$deb" >/dev/null
    fi
fi
dpkg-deb --info "$deb" | sed -n 's/^ \(Package\|Version\|Depends\|Installed-Size\)/\1/p'
echo "package: $(($(stat -c %s "$deb") / 1000000)) MB, binary: $(($(stat -c %s "$binary") / 1000000)) MB"

root=$work/root
files() { { find "$root/usr" "$root/etc" "$root/opt" "$root/var/lib/dpkg/info" -type f 2>/dev/null || true; } | sort; }
# Removes the package and compares with the list of files from before it came.
remove() {
    "${remove[@]}" >/dev/null 2>&1
    rm -rf "$root/tmp/results"
    [[ $(files) == "$1" ]] || { echo "files stayed:"; diff <(echo "$1") <(files); exit 1; }
}
if command -v debootstrap >/dev/null && [[ $EUID -eq 0 ]]; then
    debootstrap --variant=minbase "${DEBIAN_SUITE:-bookworm}" "$root" >/dev/null
    enter=(chroot "$root")
    install() {
        "${enter[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@" >"$work/apt.log" 2>&1 ||
            { cat "$work/apt.log"; exit 1; }
    }
    remove=("${enter[@]}" dpkg --purge doublet)
    cp "$deb" "$root/doublet.deb"
    before=$(files)
    install /doublet.deb
else
    # An empty root with the libraries the binary is linked to and nothing else.
    mkdir -p "$root/usr" "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates" "$root/tmp" "$root/proc"
    touch "$root/var/lib/dpkg/status"
    ldd "$binary" | grep -o '/[^ ]*' | while read -r library; do install -D "$library" "$root$library"; done
    before=$(files)
    package=(dpkg --root="$root" --force-not-root --force-depends --force-script-chrootless --log="$work/dpkg.log")
    fakeroot=(); [[ $EUID -eq 0 ]] || fakeroot=(unshare --map-root-user)
    "${fakeroot[@]}" "${package[@]}" --install "$deb" >/dev/null 2>"$work/install.log" || { cat "$work/install.log"; exit 1; }
    enter=(unshare --map-root-user chroot "$root")
    remove=("${fakeroot[@]}" "${package[@]}" --purge doublet)
fi
"${enter[@]}" /usr/bin/doublet --version | tee "$work/version"
grep -q "^doublet $version (commit " "$work/version"
HOME=/tmp "${enter[@]}" /usr/bin/doublet run builtin:demo --out /tmp/results | head -1
[[ -s $root/tmp/results/results.json ]]

# Without a display, and with one but without the libraries a window needs: one line that says what to do.
refuses() {
    local line status=0
    line=$(env -u WAYLAND_DISPLAY DISPLAY="$1" "${enter[@]}" /usr/bin/doublet builtin:demo 2>&1) || status=$?
    [[ $status -eq 1 && $(wc -l <<<"$line") -eq 1 && $line == *"$2"* ]] || { echo "display '$1': exit $status, $line"; exit 1; }
    echo "display '$1': $line"
}
refuses "" "neither DISPLAY nor WAYLAND_DISPLAY names one"
refuses :97 "apt-get install libx11-6"
if command -v desktop-file-validate >/dev/null; then desktop-file-validate packaging/doublet.desktop; fi
python3 -c 'import sys, xml.dom.minidom as x; x.parse(sys.argv[1])' "$root/usr/share/mime/packages/doublet.xml"
remove "$before"
echo "installed, run and removed without a trace"

if [[ ${enter[0]} == chroot ]]; then
    read -ra recommended < <(dpkg-deb --field "$deb" Recommends | tr -d ,)
    install "${recommended[@]}" xvfb x11-utils libglib2.0-bin shared-mime-info desktop-file-utils
    before=$(files)
    install /doublet.deb
    cp sessions/demo.toml "$root/tmp/flight.doublet.toml"
    cp scripts/open_window.sh "$root/tmp/"
    "${enter[@]}" bash /tmp/open_window.sh /tmp/flight.doublet.toml application/x-doublet-session+toml
    remove "$before"
    echo "opened by its type under a virtual display, removed without a trace"
fi
