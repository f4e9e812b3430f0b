#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the extension's zip with the renderer inside: `python3 addons/build.py [--binary target/release/rayloom] [--output dist]`.

Without `--binary` the renderer is built first (`cargo build --release`). The zip is made for this machine's platform; where the bpy module is
installed, Blender's own `blender_ext.py validate` checks it. Needs Python 3.11 and cargo.
"""

import argparse
import glob
import importlib.util
import os
import platform
import subprocess
import sys
import tomllib
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
ADDON = os.path.join(HERE, "rayloom_blender")


def blender_platform():
    """This machine as Blender's manifests name it."""
    system = {"Linux": "linux", "Darwin": "macos", "Windows": "windows"}[platform.system()]
    machine = "arm64" if platform.machine().lower() in {"arm64", "aarch64"} else "x64"
    return f"{system}-{machine}"


def manifest_text(target):
    """The manifest with the platform of the renderer inside."""
    with open(os.path.join(ADDON, "blender_manifest.toml"), encoding="utf-8") as file:
        text = file.read()
    head, mark, build = text.partition("\n[permissions]")
    return f'{head}platforms = ["{target}"]\n{mark}{build}'


def files():
    """What goes in, relative to the add-on."""
    for folder, folders, names in os.walk(ADDON):
        folders[:] = sorted(f for f in folders if f not in {"__pycache__", "bin"})
        for name in sorted(names):
            if name.endswith((".py", ".md")):
                yield os.path.relpath(os.path.join(folder, name), ADDON)


def build_zip(binary, output):
    """Writes the zip; its path. Times in it are fixed, so that equal content gives equal bytes."""
    target = blender_platform()
    manifest = manifest_text(target)
    about = tomllib.loads(manifest)
    os.makedirs(output, exist_ok=True)
    path = os.path.join(output, f"{about['id']}-{about['version']}-{target}.zip")

    def add(archive, name, data, mode=0o644):
        info = zipfile.ZipInfo(name, (2020, 1, 1, 0, 0, 0))
        info.external_attr = (0o100000 | mode) << 16
        info.compress_type = zipfile.ZIP_DEFLATED
        archive.writestr(info, data)

    with zipfile.ZipFile(path, "w") as archive:
        add(archive, "blender_manifest.toml", manifest)
        for name in files():
            with open(os.path.join(ADDON, name), "rb") as file:
                add(archive, name.replace(os.sep, "/"), file.read())
        with open(os.path.join(HERE, "LICENSE"), "rb") as file:
            add(archive, "LICENSE", file.read())
        with open(binary, "rb") as file:
            add(archive, "bin/" + ("rayloom.exe" if target.startswith("windows") else "rayloom"), file.read(), 0o755)
    return path


def validator():
    """Blender's own checker of extensions, if the bpy module is here."""
    spec = importlib.util.find_spec("bpy")
    folder = os.path.dirname(spec.origin) if spec and spec.origin else ""
    return next(iter(glob.glob(os.path.join(folder, "*", "scripts", "addons_core", "bl_pkg", "cli", "blender_ext.py"))), None) if folder else None


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", help="a renderer that is already built")
    parser.add_argument("--output", default=os.path.join(HERE, "..", "target", "blender"), help="folder of the zip [default: target/blender]")
    args = parser.parse_args()
    binary = args.binary
    if binary is None:
        root = os.path.dirname(HERE)
        subprocess.run(["cargo", "build", "--release"], cwd=root, check=True)
        binary = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(root, "target")), "release", "rayloom")
        binary += ".exe" if platform.system() == "Windows" else ""
    path = build_zip(binary, args.output)
    print(f"{path}: {os.path.getsize(path):,} bytes")
    check = validator()
    if check is None:
        print("not validated: the bpy module is not installed")
        return 0
    return subprocess.run([sys.executable, check, "validate", path], check=False, timeout=300).returncode


if __name__ == "__main__":
    sys.exit(main())
