#!/usr/bin/env python3
"""Makes the picture pairs of this folder and asks other programs how far they are apart: NVIDIA's flip-evaluator, OpenImageIO, scikit-image.

    python3 -m venv venv && venv/bin/pip install flip-evaluator==1.7 OpenImageIO==3.2.2.0 scikit-image==0.26.0
    venv/bin/python tests/metrics/make.py

writes tests/metrics/pairs/NN_{a,b}.{png,exr} and tests/metrics/expected.json, against which tests/diff_metrics.rs holds our numbers.
The second picture of a pair is the reference.
"""

import json
import pathlib
from importlib.metadata import version

import flip_evaluator
import numpy as np
import OpenImageIO as oiio
from skimage.metrics import structural_similarity

HERE = pathlib.Path(__file__).parent
W, H = 72, 48


def scene(seed, peak):
    """A picture of gradients, edges, dots and grain, in 0..peak."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:H, 0:W]
    out = np.zeros((H, W, 3))
    for c in range(3):
        out[..., c] = 0.5 + 0.4 * np.sin(x / (4 + 3 * c) + rng.uniform(0, 6)) * np.cos(y / (5 + c) + rng.uniform(0, 6))
    out[(x // 8 + y // 8) % 2 == 0] *= rng.uniform(0.2, 0.8)
    out[(x - rng.integers(10, W - 10)) ** 2 + (y - rng.integers(10, H - 10)) ** 2 < 60] = rng.uniform(0, 1, 3)
    return np.clip(out, 0, 1) ** (1 if peak == 1 else 3) * peak


def changed(picture, kind, rng, peak):
    if kind == "noise":
        return picture + rng.normal(0, 0.03 * peak, picture.shape)
    if kind == "brighter":
        return picture * 1.01
    if kind == "much_brighter":
        return picture * 1.4
    if kind == "shifted":
        return np.roll(picture, 1, axis=1)
    if kind == "swapped":
        return picture[..., ::-1]
    if kind == "blurred":
        return (picture + np.roll(picture, 1, 0) + np.roll(picture, 1, 1) + np.roll(picture, -1, 1)) / 4
    if kind == "one_pixel":
        out = picture.copy()
        out[20, 30] = [peak, 0, peak]
        return out
    if kind == "fireflies":
        out = picture.copy()
        out[rng.integers(0, H, 12), rng.integers(0, W, 12)] = peak * 3
        return out
    if kind == "other":
        return scene(int(rng.integers(1000, 2000)), peak)
    return picture.copy()


def write(path, values):
    out = oiio.ImageOutput.create(str(path))
    kind = "uint8" if path.suffix == ".png" else "float"
    spec = oiio.ImageSpec(W, H, 3, kind)
    if kind == "float":
        spec.attribute("compression", "zip")
    out.open(str(path), spec)
    out.write_image(np.ascontiguousarray(values, dtype=np.uint8 if kind == "uint8" else np.float32))
    out.close()


def measure(a, b, linear):
    """Numbers of two files; `b` is the reference."""
    result = oiio.ImageBufAlgo.compare(oiio.ImageBuf(str(a)), oiio.ImageBuf(str(b)), 0.0, 0.0)
    p, q = (oiio.ImageBuf(str(f)).get_pixels(oiio.FLOAT) for f in (a, b))
    numbers = {"mean_absolute": result.meanerror, "rmse": result.rms_error, "largest": result.maxerror}
    if result.rms_error > 0 and not linear:
        numbers["psnr_db"] = result.PSNR
    if not linear:
        numbers["ssim"] = structural_similarity(
            p.astype(np.float64), q.astype(np.float64), channel_axis=2, gaussian_weights=True, sigma=1.5, use_sample_covariance=False,
            data_range=1.0)
    p, q = (np.ascontiguousarray(v, dtype=np.float32) for v in (p, q))
    shown = (np.clip(p, 0, 1), np.clip(q, 0, 1)) if linear else (p, q)
    numbers["flip"] = float(flip_evaluator.evaluate(shown[1], shown[0], "LDR", inputsRGB=not linear, applyMagma=False)[1])
    if linear:
        numbers["flip_hdr"] = float(flip_evaluator.evaluate(q, p, "HDR", applyMagma=False)[1])
    return numbers


def main():
    (HERE / "pairs").mkdir(exist_ok=True)
    kinds = ["noise", "brighter", "much_brighter", "shifted", "swapped", "blurred", "one_pixel", "other", "equal", "fireflies"]
    pairs = []
    for i, (kind, linear) in enumerate([(k, False) for k in kinds] + [(k, True) for k in kinds]):
        peak = 6.0 if linear else 1.0
        rng = np.random.default_rng(100 + i)
        reference = scene(i, peak)
        test = changed(reference, kind, rng, peak)
        files = [HERE / "pairs" / f"{i:02}_{side}.{'exr' if linear else 'png'}" for side in "ab"]
        for path, values in zip(files, (test, reference)):
            write(path, np.maximum(values, 0) if linear else np.round(255 * np.clip(values, 0, 1)))
        pairs.append({"a": files[0].name, "b": files[1].name, "change": kind, **measure(*files, linear)})
    programs = {name: version(name) for name in ("flip-evaluator", "OpenImageIO", "scikit-image")}
    text = json.dumps({"programs": programs, "pairs": pairs}, indent=1)
    (HERE / "expected.json").write_text(text + "\n")


main()
