# SPDX-License-Identifier: GPL-3.0-or-later
"""The renderer as a child process: one JSON object a line on its standard output, text on its standard error (`rayloom render --progress json`)."""

import json
import os
import queue
import subprocess
import sys
import threading
import time

# The most lines of standard error that are kept.
KEPT_LINES = 200


class RendererError(Exception):
    """The renderer did not make a picture; the text is for the user."""


class Renderer:
    """A running `rayloom`. Nothing here waits for long: whoever drives it asks again and again."""

    def __init__(self, command, folder):
        flags = {"creationflags": subprocess.CREATE_NO_WINDOW} if sys.platform == "win32" else {}
        self._lines = []
        self._events = queue.Queue()
        try:
            self._child = subprocess.Popen(
                command,
                # Never written to: it closes when Blender ends, however it ends, and `--stop-with-stdin` ends the renderer then.
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                cwd=folder,
                env={**os.environ, "RUST_BACKTRACE": "0"},
                **flags,
            )
        except OSError as e:
            raise RendererError(f"The renderer '{command[0]}' cannot be started: {e.strerror or e}") from e
        self._readers = [
            threading.Thread(target=self._read_events, daemon=True),
            threading.Thread(target=self._read_errors, daemon=True),
        ]
        for reader in self._readers:
            reader.start()

    def _read_events(self):
        for line in self._child.stdout:
            try:
                event = json.loads(line)
            except ValueError:
                continue
            if isinstance(event, dict):
                self._events.put(event)

    def _read_errors(self):
        for line in self._child.stderr:
            self._lines.append(line.decode("utf-8", "replace").rstrip())
            del self._lines[:-KEPT_LINES]

    def events(self):
        """What it said since the last call."""
        out = []
        while True:
            try:
                out.append(self._events.get_nowait())
            except queue.Empty:
                return out

    def running(self):
        """Whether it still runs."""
        return self._child.poll() is None

    def wait_readers(self):
        """After its end: until all that it said is here."""
        for reader in self._readers:
            reader.join(timeout=2.0)

    def stop(self):
        """Ends it at once; the picture is lost."""
        if self.running():
            self._child.kill()
        self._child.wait()

    @property
    def pid(self):
        """Its process number."""
        return self._child.pid

    @property
    def error_lines(self):
        """The last lines of its standard error."""
        return list(self._lines)

    def verdict(self):
        """`None` after success, else the error in words."""
        code = self._child.returncode
        if code == 0:
            return None
        # What drivers say of the desktop that is not there is no reason.
        said = [line for line in self._lines if line.strip() and "XDG_RUNTIME_DIR" not in line]
        errors = [line for line in said if line.lower().startswith("error")] or said[-3:]
        detail = f": {' '.join(errors)}" if errors else "."
        if code is not None and code < 0:
            hint = " The system may be out of memory." if code == -9 else ""
            return f"The renderer was ended by signal {-code}.{hint}" + (f" It said{detail}" if errors else "")
        reasons = {2: "did not understand its options", 3: "found the scene wrong", 4: "could not read or write a file", 5: "could not use its device or its denoiser"}
        return f"The renderer {reasons.get(code, f'ended with code {code}')}{detail}"


def drive(renderer, on_event, is_cancelled, pause=0.05):
    """Until the renderer ends: events go to `on_event`; false when `is_cancelled()` ended it. Raises [`RendererError`]."""
    try:
        while renderer.running():
            if is_cancelled():
                return False
            for event in renderer.events():
                on_event(event)
            time.sleep(pause)
        renderer.wait_readers()
        for event in renderer.events():
            on_event(event)
    finally:
        renderer.stop()
    why = renderer.verdict()
    if why is not None:
        raise RendererError(why)
    return True
