# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last render could not carry and what the renderer said, for the log panel. Written by the render thread, read by the interface."""

import threading

# The most lines that are kept.
MOST = 500

_lock = threading.Lock()
_entries = []


def clear():
    """Before a render."""
    with _lock:
        _entries.clear()


def add(level, owner, text):
    """A finding: `error`, `warning` or `note`; the object or material that it is about, or an empty text."""
    with _lock:
        entry = (level, owner, text)
        if entry not in _entries:
            _entries.append(entry)
            del _entries[:-MOST]


def entries():
    """All findings, oldest first."""
    with _lock:
        return list(_entries)
