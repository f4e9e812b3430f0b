# SPDX-License-Identifier: GPL-3.0-or-later
"""What the depsgraph shows: every object and every instance, with its place and its switches."""

from dataclasses import dataclass

MESHES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}


@dataclass
class Shown:
    """One object as it is shown. `obj` is valid only while the depsgraph is walked."""

    key: tuple
    obj: object
    matrix: object
    random: float


def walk(depsgraph):
    """Yields a [`Shown`] for everything that the depsgraph shows."""
    for instance in depsgraph.object_instances:
        if not instance.show_self:
            continue
        obj = instance.object
        parent = instance.parent.original.name_full if instance.is_instance and instance.parent else ""
        persistent = tuple(instance.persistent_id) if instance.is_instance else ()
        key = (parent, obj.original.name_full, obj.original.library.name if obj.original.library else "", persistent)
        yield Shown(key, obj, instance.matrix_world.copy(), (instance.random_id & 0xFFFFFFFF) / 0xFFFFFFFF)


def column_major(matrix):
    """The 16 numbers of a matrix as glTF has them."""
    return [float(matrix[r][c]) for c in range(4) for r in range(4)]


def switches(obj, view_layer):
    """The extension's keys of a node: visibility, holdout, shadow catcher, ids; what is default is left out."""
    out = {}
    names = {
        "camera": "visible_camera",
        "diffuse": "visible_diffuse",
        "glossy": "visible_glossy",
        "transmission": "visible_transmission",
        "volumeScatter": "visible_volume_scatter",
        "shadow": "visible_shadow",
    }
    hidden = {key: False for key, own in names.items() if not getattr(obj, own, True)}
    original = obj.original
    if original.indirect_only_get(view_layer=view_layer):
        hidden["camera"] = False
    if hidden:
        out["visibility"] = hidden
    if getattr(obj, "is_holdout", False) or original.holdout_get(view_layer=view_layer):
        out["holdout"] = True
    if getattr(obj, "is_shadow_catcher", False):
        out["shadowCatcher"] = True
    if obj.pass_index:
        out["passIndex"] = obj.pass_index
    if tuple(obj.color) != (1.0, 1.0, 1.0, 1.0):
        out["color"] = list(obj.color)
    return out
