"""Whether Blender reads rayloom's passes: multilayer.py FILE.exr NAME WIDTH HEIGHT. Run with Blender's Python (bpy); prints what it found, exits 1 if something is missing.

The file is loaded as an image of the compositor, the matte of the object NAME is pulled by a Cryptomatte node and written to FILE.exr.matte.exr."""
import os, sys
import bpy
import numpy as np

def main(path):
    scene = bpy.context.scene
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    image = bpy.data.images.load(path)
    node = tree.nodes.new("CompositorNodeImage")
    node.image = image
    outputs = [o.name for o in node.outputs if o.enabled]
    print("type", image.type, "passes", outputs)
    assert image.type == "MULTILAYER", image.type
    for name in ("Combined", "Depth", "Normal", "DiffDir", "DiffInd", "DiffCol", "Emit", "Env", "CryptoObject00"):
        assert name in outputs, name
    matte = tree.nodes.new("CompositorNodeCryptomatteV2")
    matte.source = "IMAGE"
    matte.image = image
    layers = [i.identifier for i in matte.bl_rna.properties["layer_name"].enum_items]
    matte.layer_name = "ViewLayer.CryptoObject"
    matte.matte_id = sys.argv[2]
    out = tree.nodes.new("CompositorNodeComposite")
    tree.links.new(matte.outputs["Matte"], out.inputs["Image"])
    w, h = int(sys.argv[3]), int(sys.argv[4])
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = w, h, 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = path + ".matte.exr"
    scene.render.use_compositing = True
    for o in list(bpy.data.objects):
        if o.type == "MESH":
            bpy.data.objects.remove(o)
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    bpy.ops.render.render(write_still=True)
    print("layer", matte.layer_name, "of", layers, "wrote", scene.render.filepath)

main(sys.argv[1])
sys.stdout.flush()
os._exit(0)
