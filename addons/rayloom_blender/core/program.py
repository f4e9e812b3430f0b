# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the renderer is, whether it is new enough, what it offers."""

import json
import os
import shutil
import subprocess
import sys

# Oldest version that reads the files of this add-on.
OLDEST = (0, 1, 0)

_NAME = "rayloom.exe" if sys.platform == "win32" else "rayloom"
_checked = {}
# What `rayloom info` said, by program: drivers are slow to answer.
_devices = {}


class ProgramError(Exception):
    """There is no renderer that can be used; the text is for the user."""


def find(chosen=""):
    """The path of the renderer: the chosen one, the one in the add-on, `RAYLOOM`, the one on the search path."""
    if chosen:
        if os.path.isfile(chosen):
            return chosen
        raise ProgramError(f"The renderer chosen in the preferences is not there: '{chosen}'")
    inside = os.path.join(os.path.dirname(os.path.dirname(__file__)), "bin", _NAME)
    for path in (inside, os.environ.get("RAYLOOM", ""), shutil.which("rayloom") or ""):
        if path and os.path.isfile(path):
            return path
    raise ProgramError("The renderer 'rayloom' is missing: it is neither in the add-on nor on the search path. Choose it in the preferences.")


def _run(path, *arguments):
    try:
        done = subprocess.run([path, *arguments], capture_output=True, timeout=20, stdin=subprocess.DEVNULL, check=False)
    except (OSError, subprocess.TimeoutExpired) as e:
        raise ProgramError(f"The renderer '{path}' does not start: {e}") from e
    if done.returncode != 0:
        raise ProgramError(f"The renderer '{path}' does not work (code {done.returncode}): {done.stderr.decode('utf-8', 'replace').strip()[:200]}")
    return done.stdout.decode("utf-8", "replace")


def ensure_executable(path):
    """Extensions are unpacked without the right to execute."""
    if sys.platform != "win32" and not os.access(path, os.X_OK):
        try:
            os.chmod(path, os.stat(path).st_mode | 0o755)
        except OSError as e:
            raise ProgramError(f"The renderer '{path}' may not be executed: {e.strerror}") from e


def checked(chosen=""):
    """The path of a renderer that starts and is new enough. Asked once for each file and its date."""
    path = find(chosen)
    ensure_executable(path)
    key = (path, os.stat(path).st_mtime_ns)
    if key not in _checked:
        words = _run(path, "--version").split()
        try:
            version = tuple(int(p) for p in words[1].split("-")[0].split(".")) if words[0] == "rayloom" else None
        except (IndexError, ValueError):
            version = None
        if version is None:
            raise ProgramError(f"'{path}' is not rayloom: it says '{' '.join(words)[:80]}'")
        if version < OLDEST:
            oldest = ".".join(map(str, OLDEST))
            raise ProgramError(f"The renderer '{path}' is version {words[1]}; this add-on needs {oldest} or newer")
        _checked[key] = words[1]
    return path


def devices(path, again=False):
    """The machines that `rayloom info` lists: (identifier of `--backend`, name). Asked once, or `again`."""
    if again or path not in _devices:
        said = json.loads(_run(path, "info", "--json"))
        _devices[path] = [("cpu", said.get("cpu", "CPU")), *(("gpu", name) for name in said.get("gpus", []))]
    return _devices[path]
