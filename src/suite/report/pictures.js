// Pictures: text in the page, or scripts in a folder beside it; decoded when they are looked at, the last ones kept.
"use strict";
const DATA = JSON.parse(document.getElementById("data").textContent);
const KEPT = 240;
const decoded = new Map();
const waiting = new Map();

// What a script of the folder beside calls.
function pictureArrived(name, base64) {
  const resolve = waiting.get(name);
  waiting.delete(name);
  if (resolve) resolve(base64);
}

function base64Of(name) {
  const stored = document.getElementById("p" + name);
  if (stored) return Promise.resolve(stored.textContent);
  if (!DATA.sidecar) return Promise.reject(new Error("no such picture"));
  return new Promise((resolve, reject) => {
    waiting.set(name, resolve);
    const script = document.createElement("script");
    script.src = `${DATA.sidecar}/${name}.js`;
    script.onerror = () => reject(new Error("the folder of pictures is not beside this page"));
    script.onload = () => script.remove();
    document.head.append(script);
  });
}

// A promise of {url, width, height, image}.
function picture(name) {
  let p = decoded.get(name);
  if (p) {
    decoded.delete(name);
  } else {
    p = base64Of(name).then(text => new Promise((resolve, reject) => {
      const image = new Image();
      image.onload = () => resolve({ url: image.src, width: image.naturalWidth, height: image.naturalHeight, image });
      image.onerror = () => reject(new Error("not a picture"));
      image.src = "data:image/png;base64," + text;
    }));
  }
  decoded.set(name, p);
  if (decoded.size > KEPT) decoded.delete(decoded.keys().next().value);
  return p;
}

// Bytes of a picture: [height][width][4].
function pixels(p) {
  if (!p.data) {
    const canvas = document.createElement("canvas");
    canvas.width = p.width;
    canvas.height = p.height;
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(p.image, 0, 0);
    p.data = context.getImageData(0, 0, p.width, p.height).data;
  }
  return p.data;
}

const MAGMA = [[0, 0, 4], [28, 16, 68], [79, 18, 123], [129, 37, 129], [181, 54, 122], [229, 80, 100], [251, 135, 97], [254, 194, 135], [252, 253, 191]];

// Magma of 0..1.
function magma(v) {
  const x = Math.min(Math.max(v, 0), 1) * (MAGMA.length - 1), i = Math.min(Math.floor(x), MAGMA.length - 2), t = x - i;
  return MAGMA[i].map((a, c) => a + t * (MAGMA[i + 1][c] - a));
}
const HEAT = Array.from({ length: 256 }, (_, d) => magma(Math.log2(1 + d) / 8));

// A canvas of the difference of two pictures: "heat" is each pixel's largest on a logarithmic scale, else the channels' times `gain`.
// Of pictures of two sizes only what both have is compared; the rest is magenta.
function difference(a, b, kind, gain) {
  const width = Math.max(a.width, b.width), height = Math.max(a.height, b.height);
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d"), out = context.createImageData(width, height);
  const p = pixels(a), q = pixels(b);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const o = 4 * (y * width + x);
      out.data[o + 3] = 255;
      if (x >= Math.min(a.width, b.width) || y >= Math.min(a.height, b.height)) {
        out.data[o] = out.data[o + 2] = 255;
        continue;
      }
      const i = 4 * (y * a.width + x), j = 4 * (y * b.width + x);
      let worst = 0;
      for (let c = 0; c < 3; c++) {
        const d = Math.abs(p[i + c] - q[j + c]);
        worst = Math.max(worst, d);
        out.data[o + c] = Math.min(255, gain * d);
      }
      if (kind === "heat") for (let c = 0; c < 3; c++) out.data[o + c] = HEAT[worst][c];
    }
  }
  context.putImageData(out, 0, 0);
  return canvas;
}
