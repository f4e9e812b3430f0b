# SPDX-License-Identifier: GPL-3.0-or-later
"""A depsgraph → one file. The order: world, then everything that is shown, crowds of instances, then where it is at the other moments of the shutter."""

import bpy

from ..core.glb import Gltf
from ..core.schema import NAME, VERSION
from . import crowd, displacement, hair, instance, light, material, mesh, motion, surroundings
from .camera import camera_record
from .image import Images
from .settings import render_record
from .world import world_record

# Takes Blender's axes (z up) to glTF's (y up): -90 degrees about x.
_ROOT_ROTATION = [-0.7071067811865476, 0.0, 0.0, 0.7071067811865476]


# Who has a mesh for itself: nobody, an object, instances with about one random number.
_SHARED, _BY_OBJECT, _BY_INSTANCE = range(3)


class Log:
    """What could not be carried: (object, what), each once, in order."""

    def __init__(self):
        self.entries = []

    def __call__(self, owner, what):
        if (owner, what) not in self.entries:
            self.entries.append((owner, what))


class Exporter:
    """One export. `keep`: folder of buffers that outlive the frame (core/glb.py)."""

    def __init__(self, depsgraph, generator, keep=None, log=None):
        self.depsgraph = depsgraph
        self.scene = depsgraph.scene
        self.view_layer = depsgraph.view_layer
        self.log = log or Log()
        self.gltf = Gltf(generator, keep)
        self.images = Images(self.gltf)
        self.lights, self.curves, self.grids = [], [], []
        self.nodes = []  # (node index, keys of what it shows or None), for motion
        self._crowds, self._known = {}, {}
        self._meshes, self._materials, self._lights, self._curves = {}, {}, {}, {}
        self._atlases = {}  # by the keys of materials that were baked over faces
        self._displacements = {}  # by the keys of materials
        self._of_material, self._levels = {}, {}  # who has a material, and a mesh, for itself: by their keys
        self.deforming = {}  # by object: index of the mesh, its layout, numbers of vertices and corners
        self._reported = set()
        self._camera_node = None

    def export(self, path, frame_set=None):
        """Writes the file. `frame_set(frame, subframe)` moves time, for motion blur; without it nothing moves."""
        gltf = self.gltf
        gltf.use_extension(NAME)
        gltf.document["scene"] = 0
        root = gltf.append("nodes", {"name": "Blender", "rotation": _ROOT_ROTATION})
        gltf.append("scenes", {"name": self.scene.name, "nodes": [root]})
        extension = {"version": VERSION, "generator": gltf.document["asset"]["generator"], "root": root}
        extension["render"] = render_record(self.scene, self.view_layer)
        extension["world"] = world_record(self.scene.world, self.images, self.log)
        for shown in instance.walk(self.depsgraph):
            try:
                self._place(shown)
            except (ValueError, TypeError, AttributeError, RuntimeError) as e:
                self.log(f"Object '{shown.obj.name}'", f"it could not be exported: {e}")
        for made in self._crowds.values():
            self._place_crowd(made)
        self._camera()
        blurred = self.scene.render.use_motion_blur
        if (blurred or "vector" in extension["render"].get("passes", ())) and frame_set is not None:
            motion.write_motion(self, frame_set, blurred)
        children = [n for n, _ in self.nodes]
        if children:
            gltf.document["nodes"][root]["children"] = children
        if self._camera_node is not None:
            extension["camera"] = self._camera_node
        for key, rows in (("lights", self.lights), ("images", self.images.records), ("curves", self.curves), ("grids", self.grids)):
            if rows:
                extension[key] = rows
        if self.log.entries:
            extension["ignored"] = [{"object": o, "what": w} for o, w in self.log.entries]
        gltf.document.setdefault("extensions", {})[NAME] = extension
        gltf.write(path)
        return path

    def _node(self, shown, record, extension):
        own = {**instance.switches(shown.obj, self.view_layer), **extension}
        return self._append_node(shown.obj.name, shown.key, shown.matrix, shown.random, record, own)

    def _append_node(self, name, key, matrix, random, record, own):
        record = {"name": name, "matrix": instance.column_major(matrix), **record}
        if key[3]:
            own = {**own, "random": random}
        if own:
            record = {**record, "extensions": {**record.get("extensions", {}), NAME: own}}
        ix = self.gltf.append("nodes", record)
        self.nodes.append((ix, [key]))
        return ix

    def _place_crowd(self, made):
        """Instances as one node, but for those whose matrix only a node can hold."""
        kept, attributes, others = crowd.split(made)
        for k in others:
            self._append_node(made.name, made.keys[k], made.matrices[k], made.randoms[k], {"mesh": made.mesh}, made.switches)
        if not kept:
            return
        self.gltf.use_extension(crowd.NAME)
        extensions = {crowd.NAME: {"attributes": {name: self.gltf.accessor(array) for name, array in attributes.items()}}}
        if made.switches:
            extensions[NAME] = made.switches
        ix = self.gltf.append("nodes", {"name": made.name, "mesh": made.mesh, "extensions": extensions})
        self.nodes.append((ix, [made.keys[k] for k in kept]))

    def _place(self, shown):
        obj = shown.obj
        if obj.type in instance.MESHES:
            self._place_mesh(shown)
        elif obj.type == "LIGHT":
            self._place_light(shown)
        elif obj.type == "CURVES":
            self._place_curves(shown)
        elif obj.type in {"VOLUME", "POINTCLOUD", "GREASEPENCIL", "GPENCIL"} and obj.name not in self._reported:
            self._reported.add(obj.name)
            self.log(f"Object '{obj.name}'", f"objects of type {obj.type.title()} are left out")

    def _place_mesh(self, shown):
        obj = shown.obj
        own = obj.type == "MESH" and obj.data is not None
        known = None
        if shown.key[3] and own:
            # Instances of one object that show one mesh differ in nothing but their place.
            known = (shown.key[1:3], self._mesh_key(shown, own))
            if known in self._known:
                if self._known[known] is not None:
                    self._known[known].add(shown)
                return
        made = self._made_mesh(shown, own)
        if known is not None:
            known = (shown.key[1:3], self._mesh_key(shown, own))
        hairy = [(k, m) for k, m in enumerate(m for m in obj.modifiers if m.type == "PARTICLE_SYSTEM") if _shows_hair(m)]
        for k, modifier in hairy:
            self._place_particle_hair(shown, modifier, k)
        if known is None or hairy:
            if made is not None:
                self._node(shown, {"mesh": made}, {})
            return
        self._known[known] = None
        if made is not None:
            switches = instance.switches(obj, self.view_layer)
            group = (made, obj.name, repr(switches))
            self._known[known] = self._crowds.setdefault(group, crowd.Crowd(made, obj.name, switches))
            self._known[known].add(shown)

    def _mesh_key(self, shown, own):
        """What a mesh is known by: its data and materials, and where these ask for it, the object, and the step of an instance's random number."""
        obj = shown.obj
        slots = tuple(s.material.original.name_full if s.material else None for s in obj.material_slots)
        shared = (obj.data.as_pointer() if own else obj.original.as_pointer(), slots)
        level = self._levels.get(shared, _SHARED)
        step = surroundings.step_of(shown, obj.data) if level == _BY_INSTANCE and own else None
        return (shared, *((obj.original.name_full, step) if level else ()))

    def _made_mesh(self, shown, own):
        """Index of an object's mesh, or `None`. `own`: the mesh is the object's data, not made of it."""
        obj = shown.obj
        key = self._mesh_key(shown, own)
        if key not in self._meshes:
            self._meshes[key] = None
            data = obj.data if own else obj.to_mesh()
            try:
                if data is not None:
                    made, self._levels[key[0]] = self._mesh(shown, data)
                    key = self._mesh_key(shown, own)
                    self._meshes[key] = made
            finally:
                if not own:
                    obj.to_mesh_clear()
        return self._meshes[key]

    def _mesh(self, shown, data):
        """Index of a mesh, or `None`, and who has it for itself."""
        obj = shown.obj
        slots = [s.material for s in obj.material_slots] or [None]
        found = [(self._plain(), None) if m is None else self._material(m, shown, data) for m in slots]
        materials, keys = [ix for ix, _ in found], [key for _, key in found]
        atlas = next((self._atlases[k] for k in keys if k in self._atlases), None)
        moves = [self._displacements.get(k) for k in keys]
        displace = (lambda layout: displacement.displaced(layout, data, moves)) if any(moves) else None
        corner_uv = atlas.corner_uv() if atlas else None
        written = mesh.write_mesh(self.gltf, data, materials, obj.data.name if obj.data else obj.name, corner_uv, displace)
        level = max(self._of_material.get(k, _SHARED) for k in keys)
        if written is None:
            return None, level
        ix, layout = written
        if obj.type == "MESH" and motion.deforms(obj):
            self.deforming[obj.original.name_full] = (ix, layout, (len(data.vertices), len(data.loops)))
        return ix, level

    def _plain(self):
        """Index of the material of surfaces that have none."""
        if None not in self._materials:
            self._materials[None] = self.gltf.append("materials", material.plain_record(bpy.app.version))
        return self._materials[None]

    def _material(self, mat, shown, data):
        """Index of a material for an object and the key that it is kept by; `data`: its mesh, or `None`."""
        if mat is None:
            return None, None
        name, of_object = mat.original.name_full, shown.obj.original.name_full
        uv_names = tuple(layer.name for layer in mesh.ordered_uvs(data)) if data else ()
        color_names = tuple(a.name for a in mesh.ordered_colors(data)) if data else ()
        layers = (uv_names, color_names)
        of_instance = (name, layers, of_object, surroundings.step_of(shown, data))
        for key in ((name,), (name, layers), (name, layers, of_object), of_instance):
            if key in self._materials:
                return self._materials[key], key

        def tell(what):
            self.log(f"Material '{mat.name}'", what)

        around = surroundings.Surroundings(self.gltf, self.images, self.grids, mat, data, shown, tell)
        record, names_layers, moves = material.material_record(mat, around, self.images, uv_names, color_names)
        key = (name, layers, of_object) if around.used or moves else (name, layers) if names_layers else (name,)
        key = of_instance if around.varied else key
        self._materials[key] = self.gltf.append("materials", record)
        if around.baked_surface is not None:
            self._atlases[key] = around.baked_surface.atlas
        if moves:
            self._displacements[key] = moves
        placed = around.placed or (moves is not None and moves.in_world)
        self._of_material[key] = _BY_INSTANCE if around.varied else _BY_OBJECT if placed else _SHARED
        return self._materials[key], key

    def _place_light(self, shown):
        data = shown.obj.data
        key = data.as_pointer()
        if key not in self._lights:
            record = light.light_record(data, self.log)
            self.lights.append(record)
            punctual = light.punctual_record(record)
            plain = None
            if punctual:
                self.gltf.use_extension("KHR_lights_punctual")
                table = self.gltf.document.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})
                table["lights"].append(punctual)
                plain = len(table["lights"]) - 1
            self._lights[key] = (len(self.lights) - 1, plain)
        ix, plain = self._lights[key]
        record = {"extensions": {"KHR_lights_punctual": {"light": plain}}} if plain is not None else {}
        self._node(shown, record, {"light": ix})

    def _place_curves(self, shown):
        obj = shown.obj
        key = obj.data.as_pointer()
        if key not in self._curves:
            record = hair.curves_record(self.gltf, obj.data)
            self._curves[key] = self._finish_curves(record, shown, 0)
        if self._curves[key] is not None:
            self._node(shown, {}, {"curves": self._curves[key]})

    def _place_particle_hair(self, shown, modifier, k):
        key = (shown.obj.original.name_full, "hair", k)
        if key not in self._curves:
            record = hair.particle_hair_record(self.gltf, shown.obj, modifier.particle_system, modifier)
            slot = max(0, modifier.particle_system.settings.material - 1)
            self._curves[key] = self._finish_curves(record, shown, slot)
            if self._curves[key] is not None:
                record = {"name": f"{shown.obj.name} hair", "extensions": {NAME: {"curves": self._curves[key]}}}
                self.nodes.append((self.gltf.append("nodes", record), None))

    def _finish_curves(self, record, shown, slot):
        if record is None:
            return None
        slots = shown.obj.material_slots
        if slots:
            made, _ = self._material(slots[min(slot, len(slots) - 1)].material, shown, None)
            if made is not None:
                record["material"] = made
        self.curves.append(record)
        return len(self.curves) - 1

    def _camera(self):
        camera = self.scene.camera
        if camera is None or camera.type != "CAMERA":
            return
        evaluated = camera.evaluated_get(self.depsgraph)
        world = evaluated.matrix_world.copy()
        ix = self.gltf.append("cameras", camera_record(evaluated.data, world, self.scene.render))
        record = {"name": camera.name, "camera": ix, "matrix": instance.column_major(world)}
        self._camera_node = self.gltf.append("nodes", record)
        self.nodes.append((self._camera_node, ["camera"]))


def _shows_hair(modifier):
    """Whether a particle system renders its particles as hair."""
    settings = modifier.particle_system.settings
    return settings.type == "HAIR" and settings.render_type == "PATH"
