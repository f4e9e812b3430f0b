# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m rayloom_blender.export_blend IN.blend OUT.glb [--frame N]`: a .blend to a .glb with RAYLOOM_scene, without a window.

Needs the `bpy` module (`pip install bpy==4.5.*`), or runs inside Blender: `blender -b IN.blend --python-expr …`.
"""

import argparse
import os
import sys
import time


def export_file(source, target, frame=None):
    """Opens a .blend and writes it; the exporter, with its log."""
    import bpy

    from .exporting import export_scene

    bpy.ops.wm.open_mainfile(filepath=os.path.abspath(source))
    if frame is not None:
        bpy.context.scene.frame_set(frame)
    return export_scene(os.path.abspath(target))


def main(arguments=None):
    """The command line."""
    parser = argparse.ArgumentParser(prog="rayloom_blender.export_blend", description=__doc__)
    parser.add_argument("source", help=".blend to read")
    parser.add_argument("target", help=".glb to write")
    parser.add_argument("--frame", type=int, help="frame to export [default: the file's current one]")
    args = parser.parse_args(arguments)
    start = time.process_time()
    exporter = export_file(args.source, args.target, args.frame)
    for owner, what in exporter.log.entries:
        print(f"{owner}: {what}")
    seconds = time.process_time() - start
    print(f"{args.target}: {exporter.gltf.written_bytes} bytes, {seconds:.2f} s of CPU time")


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # the bpy module may hang at exit
