# SPDX-License-Identifier: GPL-3.0-or-later
"""What needs no Blender: the file, the shader graph in numpy, the child process. Nothing here imports bpy."""
