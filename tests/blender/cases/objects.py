# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands in a scene: instances, modifiers, particles, motion, hair, displacement, names."""

import os

import bpy
import numpy as np
import stage
from stage import beside_cycles, emission, log_texts, module, new_scene, render, say, wall


def case_instances_modifiers_and_collections():
    """Render visibility and render levels count; a collection instance shows; meshes are shared."""
    scene = new_scene()
    red = emission("Red", (1, 0, 0))
    source = wall("Source", -0.4, 0.4, -0.4, 0.4, material=red)
    hidden = wall("Hidden", -9, 9, -9, 9, y=-1, material=red)
    hidden.hide_render = True
    group = bpy.data.collections.new("Group")
    group.objects.link(source)
    scene.collection.objects.unlink(source)
    for k in range(3):
        empty = bpy.data.objects.new(f"I{k}", None)
        empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", group, ((k - 1) * 1.2, 0, 0)
        scene.collection.objects.link(empty)
    array = wall("Array", -1.6, -1.4, 0.8, 1.0, material=emission("Green", (0, 1, 0)))
    modifier = array.modifiers.new("A", "ARRAY")
    modifier.count, modifier.relative_offset_displace = 4, (2, 0, 0)
    p = render()
    assert p[24, 32, 0] > 0.9 and p[24, 32 + 21, 0] > 0.9 and p[24, 32 - 21, 0] > 0.9, "three instances"
    assert p[2, 2, 0] == 0.0, "what is hidden from renders is not there"
    greens = (p[:, :, 1] > 0.5).any(axis=0)
    assert np.count_nonzero(np.diff(greens.astype(int)) == 1) == 4, "four copies of the array"
    document = module("exporting").export_scene(os.path.join(stage.FOLDER, "shared.glb"), scene).gltf.document
    assert len(document["meshes"]) == 2, "instances share their mesh"


def case_geometry_nodes_and_particles_are_cycles():
    """Instances on points, a collection's children, hair and objects of particle systems: beside Cycles' picture."""
    scene = new_scene((96, 64))
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 3.0
    source = wall("Source", -0.05, 0.05, -0.05, 0.05, material=emission("Red", (1, 0, 0)))
    source.hide_render = True
    grid = wall("Grid", -1.4, -0.4, 0, 0.9)
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    points, place, info = (tree.nodes.new(f"GeometryNode{k}") for k in ("MeshGrid", "InstanceOnPoints", "ObjectInfo"))
    points.inputs["Vertices X"].default_value = points.inputs["Vertices Y"].default_value = 5
    info.inputs["Object"].default_value = source
    info.inputs["As Instance"].default_value = True
    move = tree.nodes.new("GeometryNodeTransform")
    move.inputs["Rotation"].default_value, move.inputs["Translation"].default_value = (np.pi / 2, 0, 0), (-0.8, 0, 0.4)
    tree.links.new(points.outputs[0], move.inputs["Geometry"])
    tree.links.new(move.outputs[0], place.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], place.inputs["Instance"])
    tree.links.new(place.outputs[0], end.inputs[0])
    assert start
    grid.modifiers.new("Scatter", "NODES").node_group = tree
    for name, x, settings in (("Hairy", 0.5, {"type": "HAIR", "count": 60, "hair_length": 0.5}), ("Dusty", -0.9, {"type": "EMITTER", "count": 30, "render_type": "OBJECT"})):
        ground = wall(name, x - 0.4, x + 0.4, -0.9, -0.2, material=emission(f"G {name}", (0, 0.2, 0.4)))
        if name == "Dusty":
            ground.show_instancer_for_render = False
        else:
            ground.rotation_euler, ground.location = (-np.pi / 2, 0, 0), (0, 0, -0.9)
        made = ground.modifiers.new("P", "PARTICLE_SYSTEM").particle_system.settings
        for key, value in settings.items():
            setattr(made, key, value)
        if name == "Hairy":
            made.root_radius, made.tip_radius, made.radius_scale = 1.0, 0.5, 0.04
        else:
            made.instance_object, made.particle_size, made.frame_start, made.frame_end, made.lifetime = source, 0.8, 0, 0, 100
            made.physics_type = "NO"
    scene.frame_set(2)
    ours, theirs = beside_cycles("scatter", (96, 64), 32)
    document = module("exporting").export_scene(os.path.join(stage.FOLDER, "scatter.glb"), scene).gltf.document
    crowds = [n for n in document["nodes"] if "EXT_mesh_gpu_instancing" in n.get("extensions", {})]
    off = float(np.abs(ours - theirs).mean())
    reds = [int((a[..., 0] > 0.5).sum()) for a in (ours, theirs)]
    say(f"mean difference {off:.4f} of {theirs.mean():.3f}, red pixels {reds}, {len(crowds)} crowds")
    assert off < 0.01 and reds[1] > 100 and abs(reds[0] - reds[1]) < 0.05 * reds[1] and len(crowds) == 1, (off, reds, len(crowds))
    assert (theirs[36:, 48:, 2] > 0.1).sum() > 50, "there is hair"


def case_instances_differ_by_their_random_number():
    """Object Info, Random: a crowd of instances beside Cycles' picture, to the steps that it is rounded to."""
    scene = new_scene((96, 96))
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 3.2
    material = emission("Varied", (1, 1, 1))
    tree = material.node_tree
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (1, 0, 0.2, 1), (0, 0.8, 0.2, 1)
    tree.links.new(tree.nodes.new("ShaderNodeObjectInfo").outputs["Random"], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], next(n for n in tree.nodes if n.type == "EMISSION").inputs["Color"])
    source = wall("Source", -0.15, 0.15, -0.15, 0.15, material=material)
    mesh = bpy.data.meshes.new("Places")
    mesh.from_pydata([(x * 0.4 - 1.4, 0, z * 0.4 - 1.4) for x in range(8) for z in range(8)], [], [])
    parent = bpy.data.objects.new("Parent", mesh)
    scene.collection.objects.link(parent)
    source.parent, parent.instance_type = parent, "VERTS"
    ours, theirs = beside_cycles("random", (96, 96), 16)
    document = module("exporting").export_scene(os.path.join(stage.FOLDER, "random.glb"), scene).gltf.document
    off = np.abs(ours - theirs)[6::12, 6::12]
    say(f"off by {off.max():.4f} at most, {off.mean():.4f} in the mean; {len(document['meshes'])} meshes, {len(document['materials'])} materials")
    assert off.max() < 0.04 and theirs[6::12, 6::12, 0].std() > 0.2 and 8 < len(document["meshes"]) <= 16, off.max()
    assert any("rounded to 16 steps" in t for t in log_texts()), log_texts()


def case_crowds_are_one_node():
    """Many instances of an object are one node, each where its own node would be; a sheared one is a node by itself."""
    scene = new_scene((96, 48))
    source = wall("Source", -0.1, 0.1, -0.1, 0.1, material=emission("White", (1, 1, 1)))
    places = [(x * 0.3 - 1.05, 0, z * 0.3 - 0.45) for x in range(8) for z in range(4)]
    mesh = bpy.data.meshes.new("Places")
    mesh.from_pydata(places, [], [])
    parent = bpy.data.objects.new("Parent", mesh)
    scene.collection.objects.link(parent)
    source.parent, parent.instance_type = parent, "VERTS"
    parent.scale, source.rotation_euler = (1.2, 1, 1), (0, 0.4, 0)
    sheared = render("sheared")
    export = module("exporting").export_scene
    document = export(os.path.join(stage.FOLDER, "sheared.glb"), scene).gltf.document
    assert len(document["nodes"]) == 34 and "EXT_mesh_gpu_instancing" not in document["extensionsUsed"], "shear stays in nodes"
    source.rotation_euler = (0, 0, 0)
    crowd = render("crowd")
    document = export(os.path.join(stage.FOLDER, "crowd.glb"), scene).gltf.document
    assert len(document["nodes"]) == 3, "root, camera, crowd"
    module("bridge.crowd").FROM = 1000
    assert len(export(os.path.join(stage.FOLDER, "nodes.glb"), scene).gltf.document["nodes"]) == 34
    assert np.abs(render("nodes") - crowd).max() < 1e-5, "both ways show one picture"
    assert crowd[..., 0].mean() > 0.05 and np.abs(crowd - sheared).max() > 0.5


def case_vertices_are_blurred_as_cycles_is_told():
    """Vertices and normals come at as many times as the motion steps ask for; objects that Cycles leaves out stand still."""
    scene = new_scene((64, 48), samples=16)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0

    def growing(name, x, smooth):
        obj = wall(name, x - 0.2, x + 0.2, -0.2, 0.2, material=emission(f"E {name}", (1, 1, 1)))
        obj.shape_key_add(name="Basis")
        key = obj.shape_key_add(name="Up")
        for point in key.data:
            point.co.z += 1.0
        for frame, value in ((0, 0.0), (2, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        for polygon in obj.data.polygons:
            polygon.use_smooth = smooth
        return obj

    moved, flat, rigid, still = (growing(n, x, n != "Flat") for n, x in (("Moved", -0.9), ("Flat", -0.3), ("Rigid", 0.3), ("Still", 0.9)))
    moved.cycles.motion_steps, rigid.cycles.use_deform_motion, still.cycles.use_motion_blur = 2, False, False
    scene.frame_set(1)
    document = module("exporting").export_scene(os.path.join(stage.FOLDER, "blur.glb"), scene).gltf.document
    motions = {m["name"]: m["primitives"][0].get("extensions", {}).get("RAYLOOM_scene", {}).get("motion") for m in document["meshes"]}
    assert len(motions["Moved"]["times"]) == 5 == len(motions["Moved"]["positions"]) == len(motions["Moved"]["normals"]), "2 steps are 5 times"
    assert "normals" not in motions["Flat"] and motions["Rigid"] is None and motions["Still"] is None, motions
    p = render()
    # The walls are 7.1 pixels high and move up by 8.9 while the shutter is open: no row of a moving one is white throughout.
    column = lambda x: p[:, int(32 + x * 17.8), 0]  # noqa: E731
    assert column(0.9).max() > 0.95 and column(0.3).max() > 0.95, "what stands still is sharp"
    assert 0.2 < column(-0.9).max() < 0.95 and 0.2 < column(-0.3).max() < 0.95, (column(-0.9).max(), column(-0.3).max())


def case_objects_without_material_and_empty_scenes():
    """Neither is an error."""
    scene = new_scene()
    assert np.all(render()[:, :, :3] == 0), "nothing is black"
    obj = wall("Bare", -9, 9, -9, 9)
    obj.data.materials.append(None)
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.rotation_euler = 3.14159, (np.pi / 2, 0, 0)
    scene.collection.objects.link(lamp)
    p = render()
    assert 0.5 < p[24, 32, 0] < 1.1, p[24, 32]


def case_unicode_names():
    """Names in any script, and a folder with spaces."""
    stage.FOLDER = os.path.join(stage.FOLDER, "ordner mit ä 空間 100%")
    os.makedirs(stage.FOLDER)
    new_scene()
    wall("Würfel 立方体 🐒", -9, 9, -9, 9, material=emission("Matière \"été\" \\ 光", (0, 1, 0)))
    bpy.context.scene.name = "Szene ☂"
    p = render("bild ☀")
    assert np.allclose(p[24, 32, :3], (0, 1, 0), atol=1e-3), p[24, 32]
    exporter = module("exporting").export_scene(os.path.join(stage.FOLDER, "ausfuhr ☀.glb"))
    assert any(n["name"].startswith("Würfel") for n in exporter.gltf.document["nodes"])


def case_hair_that_varies_along_itself_has_its_mean():
    """A ramp from root to tip is not followed: its mean is taken, and told."""
    scene = new_scene((32, 32), samples=16)
    curves = bpy.data.hair_curves.new("Hair")
    curves.add_curves([2] * 20)
    points = np.stack([np.repeat(np.linspace(-1, 1, 20), 2), np.zeros(40), np.tile([-1.0, 1.0], 20)], axis=-1)
    curves.attributes["position"].data.foreach_set("vector", points.astype(np.float32).ravel())
    curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", np.full(40, 0.08, np.float32))
    material = emission("H", (1, 1, 1))
    tree = material.node_tree
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (1, 0, 0, 1), (0, 0.5, 1, 1)
    tree.links.new(tree.nodes.new("ShaderNodeHairInfo").outputs["Intercept"], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], next(n for n in tree.nodes if n.type == "EMISSION").inputs["Color"])
    curves.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("Hair", curves))
    p = render()
    assert np.allclose(p[16, 16, :3], (0.5, 0.25, 0.5), atol=0.02), p[16, 16]
    assert any("along hairs" in t for t in log_texts()), log_texts()


def case_displacement_is_cycles():
    """Bump from displacement, moved vertices and both, under a low sun, beside Cycles' picture."""
    scene = new_scene((192, 72))
    for k, method in enumerate(("BUMP", "DISPLACEMENT", "BOTH")):
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=60, y_subdivisions=60, size=1.1, location=(1.2 * (k - 1), 0, 0), rotation=(np.pi / 2, 0, 0))
        bpy.ops.object.shade_smooth()
        material = bpy.data.materials.new(method)
        material.use_nodes = True
        if hasattr(material, "displacement_method"):
            material.displacement_method = method
        else:
            material.cycles.displacement_method = method
        tree = material.node_tree
        noise, move = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeDisplacement")
        noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 4.0, 0.0
        move.inputs["Scale"].default_value = 0.25
        tree.links.new(noise.outputs[0], move.inputs["Height"])
        tree.links.new(move.outputs[0], tree.nodes["Material Output"].inputs["Displacement"])
        bpy.context.object.data.materials.append(material)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3.0, (0.5, 0.9, 0)
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("World")
    ours, theirs = beside_cycles("displaced", (192, 72), 64)
    off = {}
    for k, method in enumerate(("BUMP", "DISPLACEMENT", "BOTH")):
        part = np.s_[18:54, 96 + 64 * (k - 1) - 24 : 96 + 64 * (k - 1) + 24]
        a, b = ours[part], theirs[part]
        off[method] = (float(np.abs(a - b).mean()), float(a.mean() / b.mean()), float(b.std()))
    say(", ".join(f"{k}: mean difference {v[0]:.4f}, mean {v[1]:.4f} of Cycles', spread {v[2]:.3f}" for k, v in off.items()))
    # Cycles 4.2's own bumps are others than 4.5's, by a tenth of the spread.
    share = 0.15 if bpy.app.version >= (4, 5) else 0.2
    for method, (difference, mean, spread) in off.items():
        # With both, ours has the normals of the surface that was not moved below the bumps, which darkens steep ones.
        assert spread > 0.03 and difference < share * spread and abs(mean - 1.0) < (0.05 if method == "BOTH" else 0.03), (method, off[method])
    assert not [t for t in log_texts() if "isplacement" in t], log_texts()
