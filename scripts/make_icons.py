#!/usr/bin/env python3
"""Draws packaging/doublet.svg as the icons that packagers take: PNG for Linux, ICNS for macOS, ICO for Windows.

    scripts/make_icons.py            writes packaging/icons/
    scripts/make_icons.py --check    exit code 1 if an icon is missing or has wrong sizes; draws nothing

Needs cairosvg and Pillow to draw, Pillow to check (`pip install cairosvg pillow`).
"""
import io
import pathlib
import sys

PACKAGING = pathlib.Path(__file__).resolve().parent.parent / "packaging"
ICONS = PACKAGING / "icons"
PNG_SIZES = (32, 128, 256, 512)
ICO_SIZES = (16, 24, 32, 48, 64, 256)
# Pixels of the images of an ICNS file, those of double density among them.
ICNS_SIZES = (32, 64, 128, 256, 512, 1024)


def load_pillow():
    try:
        from PIL import Image
    except ImportError:
        sys.exit("Pillow is missing: pip install pillow")
    return Image


def draw() -> None:
    image = load_pillow()
    try:
        import cairosvg
    except (ImportError, OSError) as error:
        sys.exit(f"cairosvg cannot be loaded: {error}: pip install cairosvg, and install the library cairo")
    source = (PACKAGING / "doublet.svg").read_bytes()

    def pixels(size: int):
        png = cairosvg.svg2png(bytestring=source, output_width=size, output_height=size)
        return image.open(io.BytesIO(png)).convert("RGBA")

    ICONS.mkdir(exist_ok=True)
    for size in PNG_SIZES:
        pixels(size).save(ICONS / f"{size}x{size}.png", optimize=True)
    icons = [pixels(size) for size in ICO_SIZES]
    icons[-1].save(ICONS / "doublet.ico", sizes=[(size, size) for size in ICO_SIZES], append_images=icons[:-1])
    drawn = [pixels(size) for size in ICNS_SIZES]
    drawn[-1].save(ICONS / "doublet.icns", append_images=drawn[:-1])


def check() -> None:
    image = load_pillow()
    wrong = []

    def expect(name: str, found, expected) -> None:
        if found != expected:
            wrong.append(f"{name} has {found}, expected {expected}")

    for size in PNG_SIZES:
        with image.open(ICONS / f"{size}x{size}.png") as icon:
            expect(f"{size}x{size}.png", (icon.format, icon.size), ("PNG", (size, size)))
    with image.open(ICONS / "doublet.ico") as icon:
        expect("doublet.ico", sorted(size for size, _ in icon.info["sizes"]), sorted(ICO_SIZES))
    with image.open(ICONS / "doublet.icns") as icon:
        found = sorted({width * scale for width, _, scale in icon.info["sizes"]})
        expect("doublet.icns", found, sorted(ICNS_SIZES))
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"icons: {len(PNG_SIZES)} png, ico, icns, {sum(file.stat().st_size for file in ICONS.iterdir()) / 1000:.0f} kB")


if __name__ == "__main__":
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    try:
        if not sys.argv[1:]:
            draw()
        check()
    except FileNotFoundError as error:
        sys.exit(f"{error.filename} is missing: scripts/make_icons.py draws it")
