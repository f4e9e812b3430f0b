#!/usr/bin/env python3
"""Writes film.txt: the values that POV-Ray 3.7.0.10 puts into its files for 40 colours, in every format, gamma and version.

Needs `povray` and the packages numpy, pypng, OpenEXR. `colour:` lines give the pigments (rgbt); every other line is
`#version assumed_gamma File_Gamma options: values`, all values of the file, row by row.
"""
import itertools, pathlib, subprocess, tempfile
import numpy, OpenEXR, png

WIDTH, HEIGHT = 8, 5
# Values that 64-bit arithmetic rounds to other numbers of 16 bits than POV-Ray's 32-bit arithmetic.
TIES = [
    0.768582752787, 0.871190920087, 0.984605198388, 0.68639263259, 0.744687891821, 0.514246234181, 0.91720252514, 0.648314603122,
    0.379853953659, 0.65104080665, 0.66089371578, 0.562736092094, 0.724938395361, 0.955178945061, 0.479761081321, 0.322936738926,
    0.625482098687, 0.844595096404, 0.473205160586, 0.186930641692, 0.508773923494, 0.340634758206, 0.115930418413, 0.825673268567]
COLOURS = (
    [(v, v, v, 0) for v in (0, 0.0005, 0.003, 0.01, 0.1, 0.2, 0.508, 1)]
    + [(0.8, 0.5, 0.2, t) for t in (0, 0.25, 0.5, 0.75, 1)] + [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)]
    + [(3, 0.5, 0.25, t) for t in (0, 0.5, 0.75)] + [(-0.25, 0.5, 2, t) for t in (0, 0.5)] + [(6, 1, 4, 0.5), (0.02, 0.02, 0.02, 0.75), (0.9, 0.1, 0.1, 0.75)]
    + [(0.3 + 0.013 * i, 0.3 + 0.003 * i, 0.7 - 0.011 * i, 0.125 * i) for i in range(8)]
    + [(*TIES[i:i + 3], 0) for i in range(0, 24, 3)]
)

def scene(version, gamma):
    text = f"#version {version};\n" if version != "none" else ""
    text += f"global_settings {{ assumed_gamma {gamma} }}\n" if gamma != "none" else ""
    text += f"camera {{ orthographic location <0,0,-5> direction z right {WIDTH}*x up {HEIGHT}*y }}\n"
    for i, (r, g, b, t) in enumerate(COLOURS):
        x, y = i % WIDTH - WIDTH / 2 + 0.5, HEIGHT / 2 - 0.5 - i // WIDTH
        text += f"disc {{ <{x},{y},0>, z, 0.6 pigment {{ rgbt <{r},{g},{b},{t}> }} finish {{ ambient 1 diffuse 0 }} }}\n"
    return text

def values(path):
    data = path.read_bytes()
    if path.suffix == ".png":
        return [v for row in png.Reader(bytes=data).read()[2] for v in row]
    if path.suffix == ".tga":
        n = data[16] // 8
        a = numpy.frombuffer(data[18:18 + WIDTH * HEIGHT * n], numpy.uint8).reshape(-1, n)
        return a[:, [2, 1, 0] + [3] * (n == 4)].flatten().tolist()
    if path.suffix == ".bmp":
        n = data[28] // 8
        a = numpy.frombuffer(data[54:], numpy.uint8).reshape(HEIGHT, WIDTH, n)[::-1]
        return a[:, :, [2, 1, 0] + [3] * (n == 4)].flatten().tolist()
    if path.suffix == ".ppm":
        lines = [l for l in data.split(b"\n")[:20] if not l.startswith(b"#")]
        deep = int(lines[2]) > 255
        n = WIDTH * HEIGHT * 3 * (1 + deep)
        return numpy.frombuffer(data[-n:], ">u2" if deep else numpy.uint8).tolist()
    if path.suffix == ".hdr":
        rest = data[data.index(b"\n", data.index(b"\n\n") + 2) + 1:]
        out, at = [], 0
        for _ in range(HEIGHT):
            assert rest[at:at + 4] == bytes([2, 2, 0, WIDTH])
            at += 4
            planes = []
            for _ in range(4):
                plane = []
                while len(plane) < WIDTH:
                    k = rest[at]
                    plane += [rest[at + 1]] * (k - 128) if k > 128 else list(rest[at + 1:at + 1 + k])
                    at += 2 if k > 128 else 1 + k
                planes.append(plane)
            for r, g, b, e in zip(*planes):
                out += [float(c) * 2.0 ** (e - 136) for c in (r, g, b)]
        return out
    with OpenEXR.File(str(path), separate_channels=True) as f:
        planes = f.channels()
        return numpy.stack([planes[c].pixels for c in "RGBA" if c in planes], -1).astype(float).flatten().tolist()

def main():
    print("# Written by film.py with POV-Ray 3.7.0.10.")
    for c in COLOURS:
        print("colour:", *(f"{v:.12g}" for v in c))
    cases = [(s, g, f"+FN16 File_Gamma={f}") for (s, g), f in itertools.product(
        (("3.7", "1.0"), ("3.7", "2.2"), ("3.7", "srgb"), ("3.7", "none"), ("3.6", "1.0"), ("3.6", "none"), ("none", "none")), ("srgb", "1.0", "2.2"))]
    cases += [("3.7", g, o) for g in ("1.0", "2.2") for o in (
        "+FN", "+FN +UA", "+FN16 +UA", "+FN5", "+FN7 +UA", "+FN10", "+FNg", "+FNg +UA", "+FN +TH", "+FN +UA +TH", "+FN16 +TH", "+FN +THB2", "+FN +UA +THB3", "+FN +THB4", "+FN +UA +THD1", "+FN +THD2", "+FT", "+FT +UA", "+FB",
        "+FB +UA", "+FP", "+FP +UA", "+FP12", "+FH", "+FH +UA", "+FE", "+FE +UA", "+FH File_Gamma=1.0", "+FT File_Gamma=1.0 +UA")]
    cases += [("3.6", "none", o) for o in ("+FN16 +UA", "+FH", "+FE", "+FNg")]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for version, gamma, options in cases:
            for old in folder.iterdir():
                old.unlink()
            (folder / "s.pov").write_text(scene(version, gamma))
            subprocess.run(["povray", "+Is.pov", "+Oout", f"+W{WIDTH}", f"+H{HEIGHT}", "-D", "+WT1", "-A", *options.split()],
                cwd=folder, check=True, capture_output=True)
            (picture,) = folder.glob("out.*")
            print(f"{version} {gamma} {options}:", *(f"{v:.17g}" for v in values(picture)))

main()
