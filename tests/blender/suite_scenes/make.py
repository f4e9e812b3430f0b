#!/usr/bin/env python3
"""Makes the suite's scenes for path tracing: `make.py [NAME ...]`, with a Python that has bpy 4.5.

Each case of tests/scenes/path/ gets its scene.blend (what Cycles renders) and, by the extension's exporter, the scene.glb beside it (what rayloom
renders), and a test.toml where it has none. References then come by
`rayloom suite tests/scenes --make-references cycles --reference-program PYTHON path`.
"""

import os
import pathlib
import sys
import traceback

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "addons"), str(ROOT / "tests" / "blender")]

import bpy  # noqa: E402
from rayloom_blender.exporting import export_scene  # noqa: E402
from suite_scenes import cameras, lamps, materials, stage, textures, volumes  # noqa: E402

MODULES = (cameras, lamps, materials, textures, volumes)
TEST = """about = "{about}"
options = "--integrator path --spp {spp}"
backends = ["cpu"]
references = ["golden", "cycles"]
seeds = [1, 2, 3, 4]
size = [{size[0]}, {size[1]}]
"""


def make(name):
    """One case's files."""
    build, about, size, spp = stage.CASES[name]
    folder = ROOT / "tests" / "scenes" / "path" / name
    folder.mkdir(parents=True, exist_ok=True)
    scene = stage.fresh(size)
    scene.cycles.samples = spp
    build()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"), compress=True, check_existing=False)
    (folder / "scene.blend1").unlink(missing_ok=True)
    exporter = export_scene(str(folder / "scene.glb"))
    for owner, what in exporter.log.entries:
        print(f"{name}: {owner}: {what}")
    test = folder / "test.toml"
    if not test.exists():
        test.write_text(TEST.format(about=about, spp=spp, size=size))


def main(wanted):
    """All cases, or those that contain one of the words."""
    names = [n for n in sorted(stage.CASES) if not wanted or any(w in n for w in wanted)]
    failed = []
    for name in names:
        try:
            make(name)
        except Exception:
            traceback.print_exc()
            failed.append(name)
    if failed:
        print(f"FAILED: {', '.join(failed)}")
    print(f"{len(names) - len(failed)} of {len(stage.CASES)} scenes made by {len(MODULES)} modules with Blender {bpy.app.version_string}")
    return 1 if failed else 0


if __name__ == "__main__":
    code = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(code)  # the bpy module may hang at exit
