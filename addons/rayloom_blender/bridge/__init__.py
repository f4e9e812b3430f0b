# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's data → records of the file, one module a kind. Scene properties come in, JSON and arrays go out; no module keeps state."""
