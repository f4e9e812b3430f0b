# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair: curves objects, and the hair of particle systems."""

import numpy as np

from ..core.glb import ARRAY_BUFFER
from .mesh import read_array

# Radius of curves that have no attribute of it, in metres. measured against Cycles 4.5.
DEFAULT_RADIUS = 0.005


def _write(gltf, points, radii, offsets):
    return {
        "points": gltf.accessor(points, ARRAY_BUFFER, bounds=True),
        "radii": gltf.accessor(radii, ARRAY_BUFFER),
        "offsets": gltf.accessor(offsets.astype(np.uint32)),
    }


def curves_record(gltf, curves):
    """The record of a Curves datablock in its own space; `None` without curves."""
    position = curves.attributes.get("position")
    n = len(curves.curves)
    if position is None or n == 0:
        return None
    points = read_array(position.data, "vector", np.float32, 3)
    radius = curves.attributes.get("radius")
    radii = read_array(radius.data, "value", np.float32, 1) if radius else np.full(len(points), DEFAULT_RADIUS, np.float32)
    first = read_array(curves.curves, "first_point_index", np.int32, 1)
    return _write(gltf, points, radii, np.append(first, len(points)))


def particle_hair_record(gltf, obj, system, modifier):
    """The record of a hair particle system, in world space as Blender keeps it; `None` without hair."""
    settings = system.settings
    n_parents, n_children = len(system.particles), len(system.child_particles)
    first = 0 if n_children == 0 or settings.use_parent_particles else n_parents
    steps = 2 ** settings.render_step + 1
    strands, counts = [], []
    for k in range(first, n_parents + n_children):
        strand = [system.co_hair(obj, particle_no=k, step=s) for s in range(steps)]
        strand = [p for j, p in enumerate(strand) if p.length_squared > 0.0 or j == 0]
        if len(strand) > 1:
            strands.extend(strand)
            counts.append(len(strand))
    if not counts:
        return None
    points = np.array(strands, np.float32)
    # Thick at the root, thin at the tip, with the shape's curve between.
    shape, scale = settings.shape, settings.radius_scale
    power = 1.0 + shape if shape < 0.0 else 1.0 / max(1.0 - shape, 1e-3)
    parts = []
    for n in counts:
        t = np.linspace(0.0, 1.0, n) ** power
        radius = scale * (settings.root_radius * (1.0 - t) + settings.tip_radius * t)
        if settings.use_close_tip:
            radius[-1] = 0.0
        parts.append(radius)
    # Cycles' widths are diameters.
    radii = (np.concatenate(parts) * 0.5).astype(np.float32)
    return _write(gltf, points, radii, np.concatenate([[0], np.cumsum(counts)]))
