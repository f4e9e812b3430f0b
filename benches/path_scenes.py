#!/usr/bin/env python3
"""Writes the scenes on which path tracing is timed on a GPU: Mitsuba's Cornell box and two terrains, as mitsuba 3 users know them.

  benches/path_scenes.py DIR        writes cornell.glb, terrain280k.glb, terrain1500k.glb

Same shapes, colours, light, camera and number of bounces as Mitsuba's `cornell_box()` and a height field of n x n points under a constant
environment, `path` with max_depth 6 (its direct light is our 0 bounces: 4 bounces here), no Russian roulette within them as Mitsuba's rr_depth 5.
Then `rayloom bench path DIR/cornell.glb --size 1024x1024 --spp 64`. Needs numpy."""
import json, struct, sys, os
import numpy as np

class Glb:
    def __init__(self, camera, world, bounces):
        self.bin = bytearray()
        self.j = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"children": []}], "meshes": [], "materials": [],
                  "accessors": [], "bufferViews": [], "extensionsUsed": ["RAYLOOM_scene"],
                  "cameras": [{"type": "perspective", "perspective": {"yfov": camera[1], "aspectRatio": 1.0, "znear": 0.001}}]}
        self.node({"camera": 0, "matrix": [float(v) for v in camera[0].T.ravel()]})
        b = {"total": bounces, "diffuse": bounces, "glossy": bounces, "transmission": bounces, "volume": 0, "transparent": 8}
        render = {"resolution": [1024, 1024], "samples": 64, "bounces": b, "minLightBounces": bounces, "clampDirect": 0.0, "clampIndirect": 0.0,
                  "filterGlossy": 0.0}
        world = {"surface": 0, "nodes": [{"type": "background", "color": [world] * 3, "strength": 1.0}]}
        self.j["extensions"] = {"RAYLOOM_scene": {"version": 1, "root": 0, "camera": 1, "render": render, "world": world}}

    def node(self, n):
        self.j["nodes"].append(n); self.j["nodes"][0]["children"].append(len(self.j["nodes"]) - 1)

    def accessor(self, a, kind, component):
        self.j["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bin), "byteLength": a.nbytes}); self.bin += a.tobytes()
        d = {"bufferView": len(self.j["bufferViews"]) - 1, "componentType": component, "count": len(a), "type": kind}
        if kind == "VEC3": d |= {"min": [float(v) for v in a.min(0)], "max": [float(v) for v in a.max(0)]}
        self.j["accessors"].append(d); return len(self.j["accessors"]) - 1

    def material(self, *nodes):
        self.j["materials"].append({"extensions": {"RAYLOOM_scene": {"nodes": list(nodes), "surface": len(nodes) - 1}}})
        return len(self.j["materials"]) - 1

    def mesh(self, vertices, faces, material):
        p = {"attributes": {"POSITION": self.accessor(vertices.astype(np.float32), "VEC3", 5126)},
             "indices": self.accessor(faces.astype(np.uint32).ravel(), "SCALAR", 5125), "material": material}
        self.j["meshes"].append({"primitives": [p]}); self.node({"mesh": len(self.j["meshes"]) - 1})

    def write(self, path):
        self.j["buffers"] = [{"byteLength": len(self.bin)}]
        text = json.dumps(self.j).encode(); text += b" " * (-len(text) % 4); data = bytes(self.bin) + b"\0" * (-len(self.bin) % 4)
        with open(path, "wb") as f:
            f.write(b"glTF" + struct.pack("<II", 2, 28 + len(text) + len(data)))
            f.write(struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data)

def look_at(eye, at, up):
    eye, at, up = (np.array(v, float) for v in (eye, at, up))
    z = eye - at; z /= np.linalg.norm(z); x = np.cross(up, z); x /= np.linalg.norm(x)
    m = np.eye(4); m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = x, np.cross(z, x), z, eye; return m

def turn(axis, degrees):
    a = np.radians(degrees); c, s = np.cos(a), np.sin(a); i, j = [(1, 2), (2, 0), (0, 1)][axis]
    m = np.eye(4); m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c; return m

def move(*v): m = np.eye(4); m[:3, 3] = v; return m
def scale(*v): return np.diag([*v, 1.0])
def apply(m, v): return v @ m[:3, :3].T + m[:3, 3]

def diffuse(c): return {"type": "diffuse", "color": c, "roughness": 0.0}

SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float), np.array([[0, 1, 2], [0, 2, 3]])
def cube():
    v = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    q = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return v, np.array([t for a, b, c, d in q for t in ((a, b, c), (a, c, d))])

def cornell():
    g = Glb((look_at([0, 0, 3.9], [0, 0, 0], [0, 1, 0]), np.radians(39.3077)), 0.0, 4)
    white = g.material(diffuse([.885809, .698859, .666422])); green = g.material(diffuse([.105421, .37798, .076425]))
    red = g.material(diffuse([.570068, .0430135, .0443706])); radiance = np.array([18.387, 13.9873, 6.75357])
    # Shines, and reflects, on its front alone.
    lamp = g.material(diffuse([.885809, .698859, .666422]), {"type": "emission", "color": [float(v) for v in radiance], "strength": 1.0},
                      {"type": "add", "a": 0, "b": 1}, {"type": "geometry"},
                      {"type": "mix", "factor": {"node": 3, "output": "backfacing"}, "a": 2})
    place = lambda m, shape, material: g.mesh(apply(m, shape[0]), shape[1], material)
    place(move(0, 0.99, 0.01) @ turn(0, 90) @ scale(0.23, 0.19, 0.19), SQUARE, lamp)
    for m, material in ((move(0, -1, 0) @ turn(0, -90), white), (move(0, 1, 0) @ turn(0, 90), white), (move(0, 0, -1), white),
                        (move(1, 0, 0) @ turn(1, -90), green), (move(-1, 0, 0) @ turn(1, 90), red)):
        place(m, SQUARE, material)
    place(move(0.335, -0.7, 0.38) @ turn(1, -17) @ scale(0.3, 0.3, 0.3), cube(), white)
    place(move(-0.33, -0.4, -0.28) @ turn(1, 18.25) @ scale(0.3, 0.61, 0.3), cube(), white)
    return g

def terrain(n):
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    z = 0.15 * np.sin(9 * x) * np.cos(7 * y) + 0.05 * np.sin(31 * x + 3) * np.cos(27 * y) + 0.01 * np.sin(101 * x) * np.cos(97 * y)
    v = np.stack([x, z, y], -1).reshape(-1, 3); i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]
    f = np.concatenate([np.stack([a, c, b], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)])
    g = Glb((look_at([1.6, 1.2, 1.6], [0, 0, 0], [0, 1, 0]), np.radians(45)), 1.0, 4)
    g.mesh(v, f, g.material(diffuse([.7] * 3)))
    return g

if __name__ == "__main__":
    if len(sys.argv) != 2: sys.exit(__doc__)
    os.makedirs(sys.argv[1], exist_ok=True)
    for name, g in (("cornell", cornell()), ("terrain280k", terrain(375)), ("terrain1500k", terrain(867))):
        g.write(os.path.join(sys.argv[1], name + ".glb"))
