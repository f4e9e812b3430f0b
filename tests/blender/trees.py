# SPDX-License-Identifier: GPL-3.0-or-later
"""Trees of value nodes, and Blender's own values of them by geometry nodes: what cases/materials.py holds the baker against."""

import bpy
import numpy as np


def value_trees():
    """(name, builder): builders add nodes to a tree and give the output socket."""

    def texture(kind, output, **settings):
        def build(tree):
            node = tree.nodes.new(kind)
            for key, value in settings.items():
                if key[0].isupper():
                    named = [i for i in node.inputs if i.name == key.replace("_", " ")]
                    next((i for i in named if i.enabled), named[0]).default_value = value
                else:
                    setattr(node, key, value)
            # Names of outputs differ: "Fac" became "Factor".
            return node.outputs[output] if isinstance(output, int) else next(o for o in node.outputs if o.enabled and o.name in {output, f"{output}tor"})

        return build

    def noise(tree, seed):
        node = tree.nodes.new("ShaderNodeTexNoise")
        node.inputs["Scale"].default_value = 1.3 + seed
        return node.outputs[0]

    yield "checker", texture("ShaderNodeTexChecker", "Color", Scale=2.0, Color1=(1, 0.5, 0, 1), Color2=(0, 0.25, 1, 1))
    for detail, roughness, normalize in ((0.0, 0.5, True), (2.0, 0.5, True), (3.5, 0.7, True), (2.0, 0.5, False)):
        noise_settings = {"Scale": 3.0, "Detail": detail, "Roughness": roughness, "normalize": normalize}
        yield f"noise {detail} {roughness} {normalize}", texture("ShaderNodeTexNoise", 0, **noise_settings)
    for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "RADIAL", "SPHERICAL", "QUADRATIC_SPHERE"):
        yield f"gradient {kind}", texture("ShaderNodeTexGradient", "Color", gradient_type=kind)

    yield from noise_trees(texture)
    yield from voronoi_trees(texture)
    yield from pattern_trees(texture)

    def ramp(kind, mode="RGB"):
        def build(tree):
            node = tree.nodes.new("ShaderNodeValToRGB")
            node.color_ramp.color_mode = mode
            node.color_ramp.interpolation = kind
            node.color_ramp.elements[0].position, node.color_ramp.elements[0].color = 0.3, (1, 0, 0, 1)
            node.color_ramp.elements.new(0.5).color = (0, 1, 0.5, 1)
            node.color_ramp.elements[2].position = 0.62
            tree.links.new(noise(tree, 0), node.inputs[0])
            return node.outputs[0]

        return build

    for kind in ("LINEAR", "EASE", "CONSTANT"):
        yield f"ramp {kind}", ramp(kind)
    for kind, mode in (("CARDINAL", "RGB"), ("B_SPLINE", "RGB"), ("LINEAR", "HSV"), ("LINEAR", "HSL")):
        yield f"table {kind} {mode}", ramp(kind, mode)

    def math(operation, use_clamp):
        def build(tree):
            node = tree.nodes.new("ShaderNodeMath")
            node.operation, node.use_clamp = operation, use_clamp
            shift = tree.nodes.new("ShaderNodeMapRange")
            for k, value in ((3, -3.0), (4, 4.0)):
                shift.inputs[k].default_value = value
            tree.links.new(noise(tree, 0), shift.inputs[0])
            tree.links.new(shift.outputs[0], node.inputs[0])
            tree.links.new(noise(tree, 1), node.inputs[1])
            node.inputs[2].default_value = 0.3
            return node.outputs[0]

        return build

    for item in bpy.types.ShaderNodeMath.bl_rna.properties["operation"].enum_items:
        yield f"math {item.identifier}", math(item.identifier, item.identifier == "ADD")

    def color(tree, seed):
        node = tree.nodes.new("ShaderNodeTexNoise")
        node.inputs["Scale"].default_value = 1.3 + seed
        return next(o for o in node.outputs if o.name == "Color")

    def vector_math(operation):
        def build(tree):
            node = tree.nodes.new("ShaderNodeVectorMath")
            node.operation = operation
            for k, socket in enumerate(s for s in node.inputs if s.type == "VECTOR" and s.enabled):
                shift = tree.nodes.new("ShaderNodeVectorMath")
                shift.operation, shift.inputs[1].default_value = "SUBTRACT", (0.47, 0.52, 0.5)
                tree.links.new(color(tree, k), shift.inputs[0])
                tree.links.new(shift.outputs[0], socket)
            return next(o for o in node.outputs if o.enabled)

        return build

    for item in bpy.types.ShaderNodeVectorMath.bl_rna.properties["operation"].enum_items:
        yield f"vector {item.identifier}", vector_math(item.identifier)

    def rotated(kind, invert):
        def build(tree):
            node = tree.nodes.new("ShaderNodeVectorRotate")
            node.rotation_type, node.invert = kind, invert
            values = {"Center": (0.1, 0.2, 0.3), "Axis": (1, 2, 3), "Angle": 0.7, "Rotation": (0.3, 0.5, 0.9)}
            for socket in node.inputs:
                if socket.name in values:
                    socket.default_value = values[socket.name]
            tree.links.new(color(tree, 0), node.inputs[0])
            return node.outputs[0]

        return build

    for kind in ("AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ"):
        for invert in (False, True):
            yield f"rotate {kind} {invert}", rotated(kind, invert)

    def ranged(kind, data, use_clamp):
        def build(tree):
            node = tree.nodes.new("ShaderNodeMapRange")
            node.interpolation_type, node.data_type, node.clamp = kind, data, use_clamp
            sockets = [s for s in node.inputs if s.enabled]
            for socket, value in zip(sockets[1:], (0.4, 0.6, 2.0, -1.0, 3.0)):
                socket.default_value = value if data == "FLOAT" else (value, value + 0.1, value + 0.2)
            tree.links.new(noise(tree, 0) if data == "FLOAT" else color(tree, 0), sockets[0])
            return next(o for o in node.outputs if o.enabled)

        return build

    for kind in ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"):
        for data in ("FLOAT", "FLOAT_VECTOR"):
            for use_clamp in (False, True):
                yield f"map range {kind} {data} {use_clamp}", ranged(kind, data, use_clamp)

    def curved(kind):
        def build(tree):
            node = tree.nodes.new(kind)
            # Geometry nodes never extrapolate Float Curve; Cycles does.
            node.mapping.extend = "HORIZONTAL"
            for k, curve in enumerate(node.mapping.curves):
                curve.points[0].location = (0.35, 0.1 * k)
                curve.points[1].location = (0.65, 1.0 - 0.1 * k)
                curve.points.new(0.5, 0.3)
            node.mapping.update()
            node.inputs[0].default_value = 0.8
            tree.links.new(noise(tree, 0) if kind == "ShaderNodeFloatCurve" else color(tree, 0), node.inputs[1])
            return node.outputs[0]

        return build

    for kind in ("ShaderNodeFloatCurve", "ShaderNodeRGBCurve", "ShaderNodeVectorCurve"):
        yield f"table {kind}", curved(kind)

    def glowing(tree):
        node, scale = tree.nodes.new("ShaderNodeBlackbody"), tree.nodes.new("ShaderNodeMapRange")
        scale.inputs["To Min"].default_value, scale.inputs["To Max"].default_value = -3000.0, 12000.0
        tree.links.new(noise(tree, 0), scale.inputs[0])
        tree.links.new(scale.outputs[0], node.inputs[0])
        return node.outputs[0]

    yield "table blackbody", glowing

    def parts(mode):
        def build(tree):
            apart, together = tree.nodes.new("FunctionNodeSeparateColor"), tree.nodes.new("FunctionNodeCombineColor")
            apart.mode, together.mode = mode, mode
            tree.links.new(color(tree, 0), apart.inputs[0])
            for k in range(3):
                tree.links.new(apart.outputs[(k + 1) % 3], together.inputs[k])
            return together.outputs[0]

        return build

    for mode in ("RGB", "HSV", "HSL"):
        yield f"parts {mode}", parts(mode)

    def mix(blend):
        def build(tree):
            node = tree.nodes.new("ShaderNodeMix")
            node.data_type, node.blend_type = "RGBA", blend
            sockets = [s for s in node.inputs if s.enabled]
            sockets[0].default_value = 0.7
            tree.links.new(ramp("LINEAR")(tree), sockets[1])
            checker = tree.nodes.new("ShaderNodeTexChecker")
            checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = (0.9, 0.4, 0.2, 1), (0.1, 0.6, 0.3, 1)
            tree.links.new(checker.outputs["Color"], sockets[2])
            return next(s for s in node.outputs if s.enabled)

        return build

    blends = ["MIX", "ADD", "SUBTRACT", "MULTIPLY", "SCREEN", "DIVIDE", "DIFFERENCE", "EXCLUSION", "DARKEN", "OVERLAY", "LINEAR_LIGHT", "SOFT_LIGHT"]
    blends += ["DODGE", "BURN", "HUE", "SATURATION", "VALUE", "COLOR"]
    if bpy.app.version >= (4, 5):
        blends.append("LIGHTEN")  # 4.2 has max(a, factor b)
    for blend in blends:
        yield f"mix {blend}", mix(blend)


def noise_trees(texture):
    """Every kind, number of dimensions and output of the Noise Texture."""
    for d in (1, 2, 3, 4):
        for kind in ("FBM", "MULTIFRACTAL", "HETERO_TERRAIN", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL"):
            for output, detail, distortion in (("Fac", 2.0, 0.0), ("Fac", 2.4, 1.3), ("Color", 1.7, 0.0), ("Color", 3.0, 0.7)):
                more = {"W": 1.7} if d in {1, 4} else {}
                if kind not in {"FBM", "MULTIFRACTAL"}:
                    more["Offset"] = 0.3
                if kind in {"HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL"}:
                    more["Gain"] = 1.5
                settings = {"noise_dimensions": f"{d}D", "noise_type": kind, "Scale": 3.0, "Detail": detail, "Roughness": 0.6, "Lacunarity": 2.1, **more}
                yield f"noise {d}D {kind} {output} {detail}", texture("ShaderNodeTexNoise", output, Distortion=distortion, **settings)


# Detail, roughness, whether values are normalized.
OCTAVES = ((2.4, 0.6, True), (0.0, 0.5, False), (2.0, 0.6, False), (2.0, 0.0, True))


def voronoi_trees(texture):
    """Every feature, metric, number of dimensions and output of the Voronoi Texture, plain and in octaves."""
    for d in (1, 2, 3, 4):
        for feature in ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"):
            base = {"voronoi_dimensions": f"{d}D", "feature": feature, "Scale": 1.3, "Randomness": 0.8, **({"W": 1.7} if d in {1, 4} else {})}
            if feature == "SMOOTH_F1":
                base["Smoothness"] = 0.6
            if feature == "N_SPHERE_RADIUS":
                yield f"voronoi {d}D radius", texture("ShaderNodeTexVoronoi", "Radius", **base)
                continue
            outputs = ["Distance"] if feature == "DISTANCE_TO_EDGE" else ["Distance", "Color"] + (["Position"] if d > 1 else ["W"])
            for output in outputs:
                for detail, roughness, normalize in OCTAVES[: 1 if d == 4 and feature == "SMOOTH_F1" else 4]:
                    octaves = {"Detail": detail, "Roughness": roughness, "Lacunarity": 2.2, "normalize": normalize}
                    yield f"voronoi {d}D {feature} {output} {detail} {normalize}", texture("ShaderNodeTexVoronoi", output, **base, **octaves)
            if d == 1 or feature == "DISTANCE_TO_EDGE":
                continue
            for metric in ("MANHATTAN", "CHEBYCHEV", "MINKOWSKI"):
                more = {"Exponent": 0.7} if metric == "MINKOWSKI" else {}
                for output in ("Distance", "Color"):
                    settings = {**base, "distance": metric, **more, "normalize": d == 3}
                    yield f"voronoi {d}D {feature} {metric} {output}", texture("ShaderNodeTexVoronoi", output, **settings)


def pattern_trees(texture):
    """Wave, magic, brick and white noise."""
    for kind, directions in (("BANDS", ("X", "Y", "Z", "DIAGONAL")), ("RINGS", ("X", "Y", "Z", "SPHERICAL"))):
        for direction in directions:
            for profile, distortion in (("SIN", 0.0), ("SAW", 0.0), ("TRI", 2.0)):
                more = {"bands_direction" if kind == "BANDS" else "rings_direction": direction, "Distortion": distortion, "Phase_Offset": 0.4}
                settings = {"wave_type": kind, "wave_profile": profile, "Scale": 1.3, "Detail": 2.3, "Detail_Scale": 1.2, "Detail_Roughness": 0.6, **more}
                yield f"wave {kind} {direction} {profile}", texture("ShaderNodeTexWave", "Fac", **settings)
    for depth in range(11):
        yield f"magic {depth}", texture("ShaderNodeTexMagic", "Color" if depth else "Fac", Scale=1.3, Distortion=1.4, turbulence_depth=depth)
    colors = {"Color1": (1, 0, 0, 1), "Color2": (0, 1, 0, 1), "Mortar": (0, 0, 1, 1), "Scale": 2.0, "Mortar_Size": 0.1, "Bias": -0.1}
    for output in ("Fac", "Color"):
        for smooth in (0.0, 0.3):
            for offset, frequency, squash in ((0.5, 2, 1.0), (0.3, 3, 0.7)):
                layout = {"offset": offset, "offset_frequency": frequency, "squash": squash, "Mortar_Smooth": smooth}
                yield f"brick {output} {smooth} {offset}", texture("ShaderNodeTexBrick", output, **layout, **colors)

    def white(dimensions, output):
        def build(tree):
            # Whole numbers, so that the last bit of a coordinate does not count.
            source, floor, node = (tree.nodes.new(f"ShaderNode{k}") for k in ("TexNoise", "VectorMath", "TexWhiteNoise"))
            source.inputs["Scale"].default_value, floor.operation = 900.0, "FLOOR"
            scale = tree.nodes.new("ShaderNodeVectorMath")
            scale.operation, scale.inputs["Scale"].default_value = "SCALE", 9.0
            tree.links.new(next(o for o in source.outputs if o.name == "Color"), scale.inputs[0])
            tree.links.new(scale.outputs[0], floor.inputs[0])
            node.noise_dimensions = f"{dimensions}D"
            if dimensions > 1:
                tree.links.new(floor.outputs[0], node.inputs["Vector"])
            if dimensions in {1, 4}:
                node.inputs["W"].default_value = 2.5
            return node.outputs[output]

        return build

    for d in (1, 2, 3, 4):
        for output in ("Value", "Color"):
            yield f"white noise {d}D {output}", white(d, output)


def geometry_tree(build):
    """A tree of geometry nodes that stores what `build` gives as a colour; with the socket that it goes into."""
    tree = bpy.data.node_groups.new("G", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    store = tree.nodes.new("GeometryNodeStoreNamedAttribute")
    store.data_type, store.domain = "FLOAT_VECTOR", "POINT"
    store.inputs["Name"].default_value = "value"
    value = next(s for s in store.inputs if s.name == "Value" and s.enabled)
    tree.links.new(build(tree), value)
    tree.links.new(start.outputs[0], store.inputs[0])
    tree.links.new(store.outputs[0], end.inputs[0])
    return tree, value


def blenders_values(tree, points):
    """What a tree stores at points, (n, 3)."""
    mesh = bpy.data.meshes.new("Points")
    mesh.from_pydata(points.tolist(), [], [])
    obj = bpy.data.objects.new("Points", mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.modifiers.new("G", "NODES").node_group = tree
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    out = np.empty(3 * len(points), np.float32)
    evaluated.data.attributes["value"].data.foreach_get("vector", out)
    bpy.data.objects.remove(obj)
    return out.reshape(-1, 3)
