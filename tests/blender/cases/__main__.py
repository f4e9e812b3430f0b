# SPDX-License-Identifier: GPL-3.0-or-later
"""The cases: each installs the zip and renders by F12's own operator. Pixels are checked, not return codes: Blender says FINISHED after an exception.

Called by run_cases.py: `python tests/blender/cases ROOM NAME ZIP FOLDER` runs `case_NAME` of `ROOM.py`.
"""

import importlib
import os
import sys
import traceback

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

import stage  # noqa: E402


def main():
    """Runs one case and ends hard: the bpy module may hang at its end."""
    room, name, zip_path, stage.FOLDER = sys.argv[1:5]
    try:
        stage.install(zip_path)
        getattr(importlib.import_module(room), "case_" + name)()
        print(f"CASE {name} PASSED")
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
