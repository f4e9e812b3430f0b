// One case: its pictures as large as one likes, and all that is known of it.
"use strict";
const MODES = [["three", "Side by side"], ["swap", "Swap"], ["slider", "Slider"], ["difference", "Difference"], ["heat", "Heat map"]];
const view = { c: null, p: null, mode: "three", zoom: 1, x: 0, y: 0, split: 0.5, gain: 8, flipped: false, ours: null, theirs: null, maps: {}, fitted: true };

function openCase(c) {
  view.c = c;
  $("detail").hidden = false;
  document.body.style.overflow = "hidden";
  choosePair(shownPair(c));
}

function closeCase() {
  view.c = null;
  $("detail").hidden = true;
  document.body.style.overflow = "";
}

async function choosePair(p) {
  Object.assign(view, { p, ours: null, theirs: null, maps: {}, fitted: true });
  paint();
  const c = view.c, first = (c.pictures[0] || [])[1];
  const get = name => name ? picture(name).catch(() => null) : null;
  const [ours, theirs] = await Promise.all([get(p ? p.ours : first), get(p && p.theirs)]);
  if (view.c !== c || view.p !== p) return;
  Object.assign(view, { ours, theirs });
  paint();
}

const button = (text, pressed, onclick, title) => element("button", { "aria-pressed": pressed, onclick, title }, text);

function neighbour(step) {
  const i = shown.indexOf(view.c) + step;
  if (shown[i]) location.replace("#" + shown[i].name);
}

function paint() {
  const c = view.c;
  const [mine, other] = view.p ? view.p.pair.split("-") : ["ours", ""];
  const bar = element("div", { class: "bar", style: `--chip: var(--${c.state})` },
    element("h2", {}, c.name), element("span", { class: "state" }, WORDS[c.state]),
    element("span", { class: "tabs" }, ...c.pairs.map(p => button(p.pair + (p.state === "passed" ? "" : " ●"), p === view.p, () => choosePair(p), p.state))),
    element("span", { class: "space" }),
    element("span", { class: "modes" }, ...MODES.map(([m, word], i) => button(word, view.mode === m, () => setMode(m), `key ${i + 1}`))),
    element("span", { class: "steps" },
      button("Fit", view.fitted, fit, "key F"), button("1:1", false, () => zoomTo(1 / devicePixelRatio), "key 0"),
      button("◀", false, () => neighbour(-1), "key ←"), button("▶", false, () => neighbour(1), "key →"), button("✕", false, () => { location.hash = ""; }, "key Esc")));
  const views = element("div", { id: "views" });
  const add = (what, label) => {
    const canvas = element("canvas", {});
    canvas.what = what;
    handlers(canvas);
    views.append(element("div", { class: "view" }, canvas, element("span", {}, label)));
  };
  if (!view.ours && !view.theirs) views.append(element("p", { class: "none" }, view.c.pictures.length || view.p ? "" : "There is no picture."));
  else if (!view.ours || !view.theirs) add(view.ours ? "ours" : "theirs", view.ours ? `${mine} (ours)` : other);
  else if (view.mode === "three") {
    views.className = "four";
    [["theirs", other], ["ours", `${mine} (ours)`], ["difference", `difference × ${view.gain}`], ["heat", "heat map"]].forEach(v => add(...v));
  }
  else if (view.mode === "swap") add(view.flipped ? "theirs" : "ours", view.flipped ? other : `${mine} (ours): hover or hold space for ${other}`);
  else if (view.mode === "slider") add("slider", `${other} | ${mine} (ours)`);
  else add(view.mode, view.mode === "heat" ? "largest difference of each pixel, logarithmic: 1/255 is an eighth of the way up" : `difference × ${view.gain} (keys + and -)`);
  $("detail").replaceChildren(bar, element("div", { id: "stage" }, views, element("div", { id: "pixel" })), side(c));
  if (view.fitted) fitQuietly();
  draw();
}

function setMode(m) {
  Object.assign(view, { mode: m, flipped: false });
  paint();
}

const canvases = () => [...$("detail").querySelectorAll(".view canvas")];

function fitQuietly() {
  const canvas = canvases()[0], p = view.ours || view.theirs;
  if (!canvas || !p) return;
  view.zoom = Math.max(0.05, Math.min(canvas.clientWidth / p.width, canvas.clientHeight / p.height));
  view.x = (canvas.clientWidth - view.zoom * p.width) / 2;
  view.y = (canvas.clientHeight - view.zoom * p.height) / 2;
}

function fit() {
  view.fitted = true;
  fitQuietly();
  draw();
}

function zoomTo(zoom, x, y) {
  const canvas = canvases()[0];
  if (!canvas) return;
  x = x ?? canvas.clientWidth / 2;
  y = y ?? canvas.clientHeight / 2;
  zoom = Math.min(Math.max(zoom, 0.05), 80);
  view.x = x - (x - view.x) * zoom / view.zoom;
  view.y = y - (y - view.y) * zoom / view.zoom;
  Object.assign(view, { zoom, fitted: false });
  draw();
}

// The source of a canvas, made once a comparison.
function source(what) {
  if (what === "ours" || what === "theirs") return view[what].image;
  const key = what + (what === "difference" ? view.gain : "");
  return view.maps[key] ??= difference(view.ours, view.theirs, what, view.gain);
}

function draw() {
  for (const canvas of canvases()) {
    const ratio = devicePixelRatio, w = canvas.clientWidth, h = canvas.clientHeight;
    canvas.width = w * ratio;
    canvas.height = h * ratio;
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.imageSmoothingEnabled = view.zoom * ratio < 1;
    const put = s => context.drawImage(s, view.x, view.y, s.width * view.zoom, s.height * view.zoom);
    if (canvas.what !== "slider") {
      put(source(canvas.what));
      continue;
    }
    const x = view.split * w;
    for (const [what, from, to] of [["theirs", 0, x], ["ours", x, w]]) {
      context.save();
      context.beginPath();
      context.rect(from, 0, to - from, h);
      context.clip();
      put(source(what));
      context.restore();
    }
    context.fillStyle = "#fff";
    context.fillRect(x - 1, 0, 2, h);
    context.fillStyle = "#000";
    context.fillRect(x + 1, 0, 1, h);
  }
}

function handlers(canvas) {
  let dragged = null;
  canvas.addEventListener("wheel", e => {
    e.preventDefault();
    zoomTo(view.zoom * Math.exp(-e.deltaY / 300), e.offsetX, e.offsetY);
  }, { passive: false });
  canvas.addEventListener("pointerdown", e => {
    canvas.setPointerCapture(e.pointerId);
    dragged = [e.clientX - view.x, e.clientY - view.y];
  });
  canvas.addEventListener("pointerup", () => { dragged = null; });
  canvas.addEventListener("pointermove", e => {
    if (dragged && canvas.what !== "slider") {
      Object.assign(view, { x: e.clientX - dragged[0], y: e.clientY - dragged[1], fitted: false });
      draw();
    } else if (canvas.what === "slider") {
      view.split = e.offsetX / canvas.clientWidth;
      draw();
    }
    inspect(Math.floor((e.offsetX - view.x) / view.zoom), Math.floor((e.offsetY - view.y) / view.zoom));
  });
  canvas.addEventListener("pointerenter", () => flip(canvas, true));
  canvas.addEventListener("pointerleave", () => flip(canvas, false));
  canvas.addEventListener("dblclick", fit);
}

// Hovering swaps to the reference, without making the page anew.
function flip(canvas, on) {
  if (view.mode !== "swap" || !view.ours || !view.theirs) return;
  const target = canvas || canvases()[0];
  target.what = on ? "theirs" : "ours";
  target.nextSibling.textContent = on ? view.p.pair.split("-")[1] : `${view.p.pair.split("-")[0]} (ours)`;
  draw();
}

function inspect(x, y) {
  const at = p => p && x >= 0 && y >= 0 && x < p.width && y < p.height ? [...pixels(p).slice(4 * (y * p.width + x), 4 * (y * p.width + x) + 3)] : null;
  const a = at(view.ours), b = at(view.theirs);
  const show = v => v ? [element("i", { class: "swatch", style: `background: rgb(${v})` }), v.map(n => String(n).padStart(3)).join(" ")] : ["-"];
  const parts = a || b ? [`column ${x}, row ${y}   ours `, ...show(a)] : [];
  if (parts.length && view.theirs) parts.push("   reference ", ...show(b));
  if (a && b) parts.push(`   difference ${a.map((v, i) => v - b[i]).map(d => (d > 0 ? "+" : "") + d).join(" ")}`);
  $("pixel").replaceChildren(...parts);
}

const row = (name, ...cells) => element("tr", {}, element("th", {}, name), ...cells.map(c => c instanceof Node ? c : element("td", {}, c)));

function command(text) {
  const copy = element("button", { onclick: () => navigator.clipboard.writeText(text).then(() => { copy.textContent = "copied"; }) }, "copy");
  return element("div", { class: "command" }, element("pre", {}, text), copy);
}

function change(now, before, show) {
  if (!before) return element("td", {}, show(now));
  const ratio = now / before, cls = ratio > 1.3 ? "bad" : ratio < 0.77 ? "good" : "";
  return element("td", { class: cls }, `${show(now)} (was ${show(before)})`);
}

function side(c) {
  const out = element("aside", { id: "side", style: `--chip: var(--${c.state})` });
  if (c.about) out.append(element("h3", {}, "What it shows"), element("p", {}, c.about));
  if (c.why.length) out.append(element("h3", {}, "Why"), ...c.why.map(w => element("p", { class: "why" }, w)));
  const p = view.p, n = p && p.numbers;
  if (p) {
    const table = element("table", {}, row("tolerance", p.limits));
    if (n) {
      table.append(row("off", percent(n.percent_beyond)));
      if (n.percent_far) table.append(row("far off", percent(n.percent_far)));
      table.append(row("largest", `${(255 * n.largest).toFixed(1)}/255 at column ${n.at[0]}, row ${n.at[1]}`), row("RMSE", n.rmse.toFixed(6)),
        row("PSNR", n.psnr_db === null ? "infinite" : `${n.psnr_db.toFixed(2)} dB`), row("means", `${(100 * n.mean_ratio).toFixed(3)} % apart`));
      if (n.flip !== null) table.append(row("FLIP", n.flip.toFixed(6)));
      if (n.z) table.append(row("z-test", `${n.z[0]} beyond chance, |z| up to ${n.z[1].toFixed(2)}, rms ${n.z[2].toFixed(3)}, mean ${n.z[3].toFixed(2)}`));
    }
    table.append(row("reference", element("td", { style: "overflow-wrap: anywhere" }, p.file)));
    out.append(element("h3", {}, p.pair), table);
  }
  if (c.runs.length) {
    const table = element("table", {});
    for (const r of c.runs) table.append(row(r.machine, r.device || "", ), row("", change(r.seconds, r.last_seconds, time), r.peak_bytes ? change(r.peak_bytes, r.last_peak_bytes, memory) : ""));
    out.append(element("h3", {}, c.reused ? "Time and memory (unchanged since, not run again)" : "Time and memory, and the last run's"), table);
  }
  for (const t of c.texts.filter(t => t.state !== "passed")) {
    const lines = t.difference.split("\n").map(l => element("span", { class: l[0] === "-" ? "minus" : l[0] === "+" ? "plus" : "" }, l + "\n"));
    out.append(element("h3", {}, `Golden text: ${t.kind}`), element("pre", {}, ...lines));
  }
  out.append(element("h3", {}, "Run it again"), command(`${DATA.command} ${c.name}`), ...c.runs.map(r => command(r.command)));
  out.append(element("h3", {}, "Take it as it is now"), command(`${DATA.command} --update ${c.name}`));
  return out;
}
