# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes: textures, values, what is baked, attributes, light paths."""

import os

import bpy
import numpy as np
import stage
import trees
from stage import beside_cycles, emission, log_texts, module, new_scene, render, say, wall


def case_missing_texture_is_pink_and_told():
    """As in Cycles; the log names the picture."""
    new_scene()
    material = emission("M", (1, 1, 1))
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("gone", 4, 4)
    texture.image.source, texture.image.filepath = "FILE", "//nowhere/gone.png"
    shine = next(n for n in material.node_tree.nodes if n.type == "EMISSION")
    material.node_tree.links.new(texture.outputs[0], shine.inputs["Color"])
    wall("W", -9, 9, -9, 9, material=material)
    p = render()
    assert np.allclose(p[24, 32, :3], (1, 0, 1), atol=1e-3), p[24, 32]
    assert any("gone" in t and "missing" in t for t in log_texts()), log_texts()


def case_textures_and_uvs():
    """Pictures lie upright; sRGB is decoded; a checker is baked cell by cell."""
    new_scene((64, 64))
    image = bpy.data.images.new("quarters", 2, 2)
    image.pixels.foreach_set(np.array([(1, 0, 0, 1), (0, 1, 0, 1), (0, 0, 1, 1), (0.5, 0.5, 0.5, 1)], np.float32).ravel())
    image.update()
    material = emission("M", (1, 1, 1))
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation = image, "Closest"
    shine = next(n for n in tree.nodes if n.type == "EMISSION")
    tree.links.new(texture.outputs[0], shine.inputs["Color"])
    wall("W", -2, 2, -2, 2, material=material)
    p = render()
    expected = {(48, 16): (1, 0, 0), (48, 48): (0, 1, 0), (16, 16): (0, 0, 1), (16, 48): (0.2140, 0.2140, 0.2140)}
    for at, color in expected.items():
        assert np.allclose(p[at][:3], color, atol=4e-3), (at, p[at])
    checker = tree.nodes.new("ShaderNodeTexChecker")
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    checker.inputs["Scale"].default_value = 4
    checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = (1, 0, 0, 1), (0, 0, 1, 1)
    tree.links.new(coordinates.outputs["UV"], checker.inputs["Vector"])
    tree.links.new(checker.outputs["Color"], shine.inputs["Color"])
    p = render()
    # The wall spans 57 of 64 pixels; the lower left cell has the second colour (case_values_are_blenders).
    assert np.allclose(p[54, 10, :3], (0, 0, 1), atol=1e-2) and np.allclose(p[54, 25, :3], (1, 0, 0), atol=1e-2), (p[54, 10], p[54, 25])


def case_values_are_blenders():
    """What is folded and baked, against Blender's own evaluation of the same nodes by geometry nodes at random points."""
    rng = np.random.default_rng(3)
    points = (rng.random((400, 3)) * 8 - 4).astype(np.float32)
    worst = {}
    for name, build in trees.value_trees():
        tree, socket = trees.geometry_tree(build)
        theirs = trees.blenders_values(tree, points)
        told = []
        graph = module("bridge.nodes").Graph(None, told.append)
        link = graph.value(socket)
        assert not told, (name, told)
        points_of = lambda source, uv: points  # noqa: E731
        ours = module("core.values").as_color(module("core.evaluate").Evaluator(graph.nodes, points_of).value(link))
        if name.startswith("gradient"):
            theirs = theirs.clip(0.0, 1.0)  # as Cycles does; geometry nodes keep what lies beyond
        # Steps may fall to either side of a border; tables round kinks off, Cycles' own too.
        worst[name] = float(np.quantile(np.abs(ours - theirs) / (1.0 + np.abs(theirs)), 0.99))
        assert worst[name] < (2e-2 if name.startswith("table") else 5e-4), (name, worst[name], ours[:3], theirs[:3])
        bpy.data.node_groups.remove(tree)
    exact = {k: v for k, v in worst.items() if not k.startswith("table")}
    say(f"{len(worst)} trees of nodes, 99 % of the values within {max(exact.values()):.0e} ({max(exact, key=exact.get)}), of tables within {max(worst.values()):.0e}")


def case_baked_surfaces_look_as_in_cycles():
    """Procedural textures over generated, object and mixed coordinates: the picture against Cycles' own of the same scene."""
    scene = new_scene((96, 72), samples=16)
    bpy.ops.mesh.primitive_monkey_add(size=2.2, location=(-1.2, 0, 0))
    bpy.ops.mesh.primitive_cube_add(size=1.5, location=(1.3, 0, 0.3), rotation=(0.4, 0.3, 0.6))
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 6, 0), rotation=(np.pi / 2, 0, 0))
    for obj, coordinates, scale in zip(bpy.data.objects[1:], (None, "Object", "Generated"), (3.0, 2.0, 30.0)):
        material = emission(obj.name, (1, 1, 1))
        tree = material.node_tree
        noise, ramp = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeValToRGB")
        noise.inputs["Scale"].default_value = scale
        ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.8, 0.1, 0, 1), (0.1, 0.3, 0.9, 1)
        ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.35, 0.65
        if coordinates:
            tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs[coordinates], noise.inputs["Vector"])
        tree.links.new(noise.outputs[0], ramp.inputs[0])
        shine = next(n for n in tree.nodes if n.type == "EMISSION")
        tree.links.new(ramp.outputs["Color"], shine.inputs["Color"])
        obj.data.materials.append(material)
    ours = render("ours")
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = 16, False, "CPU"
    theirs = render("theirs")
    difference = np.abs(ours - theirs)[:, :, :3]
    say(f"mean difference from Cycles {difference.mean():.4f} (of a mean of {theirs[:, :, :3].mean():.3f}), median {np.median(difference):.4f}")
    assert np.median(difference) < 0.01 and difference.mean() < 0.02, (np.median(difference), difference.mean())


def case_procedural_textures_look_as_in_cycles():
    """Every texture node over the default coordinates of a ball, in colour, beside Cycles' picture of it."""
    scene = new_scene((192, 144))
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 4.0
    choices = (
        ("TexNoise", {"noise_dimensions": "4D"}, {"Distortion": 0.6, "W": 1.2, "Scale": 3.0}),
        ("TexNoise", {"noise_dimensions": "2D", "noise_type": "RIDGED_MULTIFRACTAL"}, {"Scale": 2.0, "Offset": 0.8}),
        ("TexVoronoi", {"feature": "F1"}, {"Scale": 4.0}),
        ("TexVoronoi", {"feature": "SMOOTH_F1", "distance": "MANHATTAN"}, {"Scale": 3.0}),
        ("TexVoronoi", {"feature": "DISTANCE_TO_EDGE"}, {"Scale": 4.0, "Detail": 1.0}),
        ("TexVoronoi", {"feature": "F2", "voronoi_dimensions": "2D", "normalize": True}, {"Scale": 3.0, "Detail": 1.5}),
        ("TexWave", {"wave_profile": "SAW"}, {"Scale": 1.0, "Distortion": 3.0}),
        ("TexMagic", {"turbulence_depth": 4}, {"Scale": 1.5}),
        ("TexBrick", {}, {"Scale": 2.0, "Mortar Smooth": 0.4}),
        ("TexGradient", {"gradient_type": "SPHERICAL"}, {}),
        ("TexChecker", {}, {"Scale": 4.0}),
        ("TexWhiteNoise", {"noise_dimensions": "1D"}, {"W": 0.7}),
    )
    for k, (kind, settings, inputs) in enumerate(choices):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.42, segments=12, ring_count=6, location=(k % 4 - 1.5, 0, 1 - k // 4))
        material = emission(kind, (1, 1, 1))
        tree = material.node_tree
        node = tree.nodes.new(f"ShaderNode{kind}")
        for key, value in settings.items():
            setattr(node, key, value)
        for socket in node.inputs:
            if socket.name in inputs:
                socket.default_value = inputs[socket.name]
        out = next((o for o in node.outputs if o.enabled and o.name == "Color"), None) or next(o for o in node.outputs if o.enabled)
        tree.links.new(out, next(n for n in tree.nodes if n.type == "EMISSION").inputs["Color"])
        bpy.context.object.data.materials.append(material)
    ours, theirs = beside_cycles("textures", (192, 144), 16)
    told = [t for t in log_texts() if "left out" in t or "not evaluated" in t]
    assert not told, told
    off = {}
    for k, (kind, settings, _) in enumerate(choices):
        y, x = 24 + 48 * (k // 4), 24 + 48 * (k % 4)
        part = np.s_[y - 20 : y + 20, x - 20 : x + 20]
        off[f"{kind} {' '.join(map(str, settings.values()))}".strip()] = float(np.abs(ours[part] - theirs[part]).mean())
    say(", ".join(f"{k} {v:.4f}" for k, v in off.items()))
    assert theirs.mean() > 0.05 and max(off.values()) < 0.02, max(off, key=off.get)


def case_attributes_and_objects_colour_materials():
    """Attributes of meshes, properties and colours of objects that share a mesh, curves and ramps of them, beside Cycles' picture."""
    new_scene((96, 24))
    scene = bpy.context.scene
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 4.0
    material = emission("M", (1, 1, 1))
    tree, n = material.node_tree, 4
    x, z = (a.ravel() for a in np.meshgrid(np.linspace(-0.4, 0.4, n), np.linspace(-0.4, 0.4, n)))
    mesh = bpy.data.meshes.new("Shared")
    corner = np.arange(n * n).reshape(n, n)
    faces = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], axis=-1).reshape(-1, 4)
    mesh.from_pydata(np.stack([x, 0 * x, z], -1).tolist(), [], faces.tolist())
    mesh.materials.append(material)
    mesh.color_attributes.new("Col", "FLOAT_COLOR", "POINT").data.foreach_set("color", np.stack([x + 0.5, z + 0.5, 0 * x + 0.2, 0 * x + 1], -1).astype(np.float32).ravel())
    mesh.attributes.new("warmth", "FLOAT", "FACE").data.foreach_set("value", np.linspace(0, 1, len(faces)).astype(np.float32))
    for k in range(4):
        obj = bpy.data.objects.new(f"O{k}", mesh)
        obj.location, obj.color, obj["glow"] = (k - 1.5, 0, 0), (0.2 * k, 0.5, 1 - 0.2 * k, 1), 0.25 * k
        scene.collection.objects.link(obj)

    def node(kind, **settings):
        out = tree.nodes.new(kind)
        for key, value in settings.items():
            setattr(out, key, value)
        return out

    def mixed(a, b, blend):
        mix = node("ShaderNodeMix", data_type="RGBA", blend_type=blend)
        sockets = [s for s in mix.inputs if s.enabled]
        sockets[0].default_value = 0.5
        tree.links.new(a, sockets[1])
        tree.links.new(b, sockets[2])
        return next(s for s in mix.outputs if s.enabled)

    curves = node("ShaderNodeRGBCurve")
    curves.mapping.curves[3].points.new(0.5, 0.8)
    curves.mapping.update()
    tree.links.new(node("ShaderNodeVertexColor", layer_name="Col").outputs["Color"], curves.inputs["Color"])
    ramp = node("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (1, 0, 0, 1), (0, 0.4, 1, 1)
    tree.links.new(next(o for o in node("ShaderNodeAttribute", attribute_name="warmth").outputs if o.name in {"Fac", "Factor"}), ramp.inputs[0])
    glow = next(o for o in node("ShaderNodeAttribute", attribute_name="glow", attribute_type="OBJECT").outputs if o.name in {"Fac", "Factor"})
    value = mixed(mixed(curves.outputs[0], ramp.outputs[0], "MIX"), mixed(node("ShaderNodeObjectInfo").outputs["Color"], glow, "ADD"), "SCREEN")
    tree.links.new(value, next(s for s in tree.nodes if s.type == "EMISSION").inputs["Color"])
    ours, theirs = beside_cycles("attributes", (96, 24), 16)
    off = [float(np.abs(ours - theirs)[3:21, 24 * k + 3 : 24 * k + 21].mean()) for k in range(4)]
    say(f"off by {', '.join(f'{v:.4f}' for v in off)} of {theirs.mean():.3f}")
    assert max(off) < 0.01 and theirs[12, 12].max() > 0.2 and np.abs(theirs[12, 12] - theirs[12, 84]).max() > 0.05, off
    assert not [t for t in log_texts() if "left out" in t or "not evaluated" in t], log_texts()


def case_light_paths_are_cycles():
    """Walls, a lamp of faces, a shadow and the world that differ by the kind of ray, beside Cycles' picture: seen straight on, in a mirror, through glass."""
    scene = new_scene((96, 32))
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", 6.0, (0, -5, 0.3)
    scene.camera.rotation_euler = (np.pi / 2, 0, 0)

    def by_ray(material, outputs):
        tree = material.node_tree
        path, parts = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeCombineColor")
        for k, name in enumerate(outputs):
            tree.links.new(path.outputs[name], parts.inputs[k])
        tree.links.new(parts.outputs[0], next(n for n in tree.nodes if n.type == "EMISSION").inputs["Color"])
        # Drawn as a light, such a face is another one than met by chance, in Cycles too.
        material.cycles.emission_sampling = "NONE"
        return material

    wall("Back", -9, 9, -9, 9, y=3, material=by_ray(emission("Back", (1, 1, 1)), ("Is Camera Ray", "Is Glossy Ray", "Is Transmission Ray")))
    wall("Behind", -9, 9, -9, 9, y=-9, material=by_ray(emission("Behind", (1, 1, 1)), ("Is Camera Ray", "Is Singular Ray", "Is Reflection Ray")))
    for k, kind in enumerate(("ShaderNodeBsdfGlass", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfDiffuse")):
        material = bpy.data.materials.new(kind)
        material.use_nodes = True
        tree = material.node_tree
        shader = tree.nodes.new(kind)
        if k < 2:
            shader.inputs["Roughness"].default_value = 0.0
        tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.8, location=(2 * (k - 1), 0, 0))
        bpy.ops.object.shade_smooth()
        bpy.context.object.data.materials.append(material)
    # A lid that only shadow rays do not see, by Mix Shader.
    lid = bpy.data.materials.new("Lid")
    lid.use_nodes = True
    tree = lid.node_tree
    mix, path = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeLightPath")
    tree.links.new(path.outputs["Is Shadow Ray"], mix.inputs[0])
    tree.links.new(tree.nodes["Principled BSDF"].outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    bpy.ops.mesh.primitive_plane_add(size=1.5, location=(2, 0, 1.2))
    bpy.context.object.data.materials.append(lid)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy = 2.0
    scene.collection.objects.link(sun)
    world = scene.world = bpy.data.worlds.new("World")
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    path, mix, end = (tree.nodes.new(f"ShaderNode{k}") for k in ("LightPath", "MixShader", "OutputWorld"))
    tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
    for k, color in ((1, (0.3, 0.6, 0.1, 1)), (2, (0.7, 0.1, 0.9, 1))):
        background = tree.nodes.new("ShaderNodeBackground")
        background.inputs["Color"].default_value = color
        tree.links.new(background.outputs[0], mix.inputs[k])
    # A gradient over the directions below it.
    where, turn, ramp = (tree.nodes.new(f"ShaderNode{k}") for k in ("TexCoord", "SeparateXYZ", "ValToRGB"))
    tree.links.new(where.outputs["Generated"], turn.inputs[0])
    tree.links.new(turn.outputs["Z"], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], next(n for n in tree.nodes if n.type == "BACKGROUND").inputs["Color"])
    tree.links.new(mix.outputs[0], end.inputs["Surface"])
    ours, theirs = beside_cycles("rays", (96, 32), 256)
    parts = {name: (float(np.abs(a - b).mean()), b.mean((0, 1)).round(3).tolist(), a.mean((0, 1)).round(3).tolist()) for name, a, b in (
        ("wall", ours[:4], theirs[:4]),
        ("glass", ours[12:26, 8:24], theirs[12:26, 8:24]),
        ("mirror", ours[12:26, 41:55], theirs[12:26, 41:55]),
        ("matt", ours[12:26, 73:87], theirs[12:26, 73:87]),
    )}  # fmt: skip
    say(", ".join(f"{k}: Cycles {v[1]}, ours {v[2]}, mean difference {v[0]:.4f}" for k, v in parts.items()))
    for name, (off, mean, _) in parts.items():
        assert off < 0.02 and max(mean) > 0.1, (name, off, mean)
    bpy.data.objects.remove(bpy.data.objects["Back"])
    bpy.data.objects.remove(bpy.data.objects["Behind"])
    ours, theirs = beside_cycles("world", (96, 32), 64)
    off = float(np.abs(ours - theirs).mean())
    say(f"without the walls, before the world: {off:.4f} of {theirs.mean((0, 1)).round(3).tolist()}")
    assert off < 0.02 and np.allclose(ours[1, 1], (0.7, 0.1, 0.9), atol=0.01), (off, ours[1, 1])


def case_projected_pictures_are_cycles():
    """Box, ball and tube projections of a picture, beside Cycles' picture of them."""
    scene = new_scene((160, 32))
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 5.0
    image = bpy.data.images.new("quarters", 16, 16, float_buffer=True)
    u, v = np.meshgrid(np.linspace(0, 1, 16), np.linspace(0, 1, 16))
    image.pixels.foreach_set(np.stack([u, v, 0.2 + 0 * u, 1 + 0 * u], -1).astype(np.float32).ravel())
    image.update()
    choices = (("BOX", 0.0), ("BOX", 0.3), ("BOX", 1.0), ("SPHERE", 0.0), ("TUBE", 0.0))
    for k, (projection, blend) in enumerate(choices):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.42, segments=24, ring_count=16, location=(k - 2, 0, 0), rotation=(0.4, 0.3, 0.9 * k))
        bpy.ops.object.shade_smooth()
        material = emission(f"M{k}", (1, 1, 1))
        tree = material.node_tree
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image, node.projection, node.projection_blend = image, projection, blend
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], node.inputs["Vector"])
        tree.links.new(node.outputs["Color"], next(n for n in tree.nodes if n.type == "EMISSION").inputs["Color"])
        bpy.context.object.data.materials.append(material)
    ours, theirs = beside_cycles("projected", (160, 32), 16)
    off = {f"{c[0]} {c[1]}": float(np.abs(ours - theirs)[4:28, 32 * k + 4 : 32 * k + 28].mean()) for k, c in enumerate(choices)}
    say(", ".join(f"{k} {v:.4f}" for k, v in off.items()))
    assert theirs.mean() > 0.1 and max(off.values()) < 0.015, off


def case_every_type_of_sky_has_its_model():
    """The types of sky that this Blender has, by the names of the file's schema, which are told apart by version; those that scatter beside Cycles."""
    expected = {
        "PREETHAM": "preetham",
        "HOSEK_WILKIE": "hosekWilkie",
        "NISHITA": "nishita",
        "SINGLE_SCATTERING": "singleScattering",
        "MULTIPLE_SCATTERING": "multipleScattering",
    }
    scene = new_scene((96, 32), 4)
    scene.camera.data.angle = 2.0
    world = scene.world = bpy.data.worlds.new("World")
    world.use_nodes = True
    tree = world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    back = next(n for n in tree.nodes if n.type == "BACKGROUND")
    back.inputs["Strength"].default_value = 0.1
    tree.links.new(sky.outputs[0], back.inputs["Color"])
    types = [item.identifier for item in sky.bl_rna.properties["sky_type"].enum_items]
    assert len(types) >= 3 and set(types) <= set(expected), types
    for kind in types:
        scene.render.engine, sky.sky_type = "RAYLOOM", kind
        document = module("exporting").export_scene(os.path.join(stage.FOLDER, "sky.glb"), scene).gltf.document
        nodes = document["extensions"]["RAYLOOM_scene"]["world"]["nodes"]
        models = [n["model"] for n in nodes if n["type"] == "sky"]
        assert models == [expected[kind]], (kind, models)
        if kind in {"PREETHAM", "HOSEK_WILKIE"}:
            continue
        sky.sun_disc, sky.sun_elevation, sky.sun_rotation = False, 0.3, 0.4
        ours, theirs = beside_cycles("sky", (96, 32), 16)
        off = float(np.abs(ours - theirs).mean() / theirs.mean())
        say(f"{kind}: {100 * off:.2f} % off")
        assert theirs[4].mean() > 0.05 and off < 0.01, (kind, off)
