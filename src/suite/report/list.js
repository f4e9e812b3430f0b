// The list: filters, order, and cards that are made as one scrolls.
"use strict";
const WORDS = { broken: "broken", failed: "failed", known_failure: "known failure", left_out: "left out", passed: "passed" };
const RANK = { broken: 0, failed: 1, known_failure: 2, left_out: 3, passed: 4 };
const PORTION = 48;
const $ = id => document.getElementById(id);

function element(tag, attributes, ...children) {
  const e = document.createElement(tag);
  for (const [k, v] of Object.entries(attributes || {})) {
    if (k === "class") e.className = v;
    else if (k.startsWith("on")) e.addEventListener(k.slice(2), v);
    else if (v !== undefined && v !== null) e.setAttribute(k, v);
  }
  e.append(...children.filter(c => c !== null && c !== undefined));
  return e;
}

const seconds = c => c.reused ? 0 : c.runs.reduce((sum, r) => sum + r.seconds, 0);
const peak = c => Math.max(0, ...c.runs.map(r => r.peak_bytes || 0));
const slowdown = c => Math.max(0, ...c.runs.filter(r => r.last_seconds).map(r => r.seconds / r.last_seconds));

// The comparison that a card shows: the one chosen, else the worst.
function shownPair(c) {
  if (filters.pair) return c.pairs.find(p => p.pair === filters.pair);
  return c.pairs.reduce((w, p) => !w || RANK[p.state] < RANK[w.state] || (p.state === w.state && p.badness > w.badness) ? p : w, null);
}

const ORDERS = {
  worst: (a, b) => RANK[a.state] - RANK[b.state] || badness(b) - badness(a) || a.name.localeCompare(b.name),
  name: (a, b) => a.name.localeCompare(b.name),
  slow: (a, b) => seconds(b) - seconds(a),
  slower: (a, b) => slowdown(b) - slowdown(a),
  large: (a, b) => peak(b) - peak(a),
};
const badness = c => filters.pair ? (shownPair(c) || { badness: 0 }).badness : c.badness;

const filters = { states: new Set(), area: "", pair: "", order: "worst", text: "" };
let shown = [];
let made = 0;

function fits(c) {
  const text = filters.text.toLowerCase();
  return (!filters.states.size || filters.states.has(c.state)) && (!filters.area || c.area === filters.area) &&
    (!filters.pair || c.pairs.some(p => p.pair === filters.pair)) &&
    (!text || (c.name + " " + c.about + " " + c.why.join(" ")).toLowerCase().includes(text));
}

function refresh() {
  shown = DATA.cases.filter(fits).sort(ORDERS[filters.order]);
  made = 0;
  $("list").replaceChildren();
  $("empty").hidden = shown.length > 0;
  $("shown").textContent = shown.length === DATA.cases.length ? "" : `${shown.length} of ${DATA.cases.length} shown`;
  for (const chip of $("states").children) chip.setAttribute("aria-pressed", filters.states.has(chip.dataset.state));
  more();
}

function more() {
  const portion = shown.slice(made, made + PORTION);
  made += portion.length;
  $("list").append(...portion.map(card));
}

function percent(v) {
  return v === 0 ? "0 %" : v < 0.01 ? "<0.01 %" : `${v.toFixed(2)} %`;
}

function time(s) {
  return s < 0.1 ? `${Math.round(1000 * s)} ms` : `${s.toFixed(2)} s`;
}

function memory(bytes) {
  return `${(bytes / 1048576).toFixed(0)} MiB`;
}

// Pictures of a card are asked for when it comes near the window.
const near = new IntersectionObserver(entries => {
  for (const e of entries.filter(e => e.isIntersecting)) {
    near.unobserve(e.target);
    e.target.load();
  }
}, { rootMargin: "400px" });

function frame(caption, width, height, swap) {
  const box = element("div", { class: "box", style: `aspect-ratio: ${width} / ${height}` });
  return [element("figure", { class: swap ? "swap" : "" }, box, element("figcaption", {}, caption)), box];
}

function trio(c, p) {
  const [w, h] = c.size, [, other] = p.pair.split("-"), [mine] = p.pair.split("-");
  const [a, boxA] = frame(other, w, h, true), [b, boxB] = frame(`${mine} (ours)`, w, h, true), [d, boxD] = frame("difference", w, h);
  const row = element("div", { class: "trio" }, a, b, d);
  row.load = async () => {
    const get = async (name, box) => {
      try {
        return name ? await picture(name) : null;
      } catch (e) {
        box.append(e.message);
        return null;
      }
    };
    const [theirs, ours] = await Promise.all([get(p.theirs, boxA), get(p.ours, boxB)]);
    const image = (q, cls) => element("img", { src: q.url, alt: "", class: cls });
    if (theirs) boxA.append(image(theirs)); else boxA.append(element("div", { class: "none" }, "no picture"));
    if (ours) boxB.append(image(ours)); else boxB.append(element("div", { class: "none" }, "no picture"));
    if (!theirs || !ours) return;
    boxA.append(image(ours, "other"));
    boxB.append(image(theirs, "other"));
    boxD.append(p.theirs === p.ours ? element("div", { class: "none" }, "equal") : difference(ours, theirs, "heat", 1));
  };
  near.observe(row);
  return row;
}

function single(c) {
  const [m, name] = c.pictures[0];
  const [f, box] = frame(`${m} (nothing to compare with)`, ...c.size);
  const row = element("div", { class: "trio" }, f);
  row.load = async () => name && box.append(element("img", { src: (await picture(name)).url, alt: "" }));
  near.observe(row);
  return row;
}

function numbers(c, p) {
  const parts = [];
  const n = p && p.numbers;
  if (p) parts.push(p.pair);
  if (n && n.z) parts.push(`|z| up to ${n.z[1].toFixed(1)}`);
  else if (n) parts.push(`${percent(n.percent_beyond)} beyond`, n.psnr_db === null ? "equal" : `${n.psnr_db.toFixed(1)} dB`);
  if (n && n.flip !== null) parts.push(`FLIP ${n.flip.toFixed(4)}`);
  if (c.runs.length) parts.push(c.reused ? "unchanged" : time(seconds(c)));
  if (peak(c)) parts.push(memory(peak(c)));
  return parts.join(" · ");
}

function card(c) {
  const p = shownPair(c);
  const texts = c.texts.filter(t => t.state !== "passed");
  const open = () => { location.hash = c.name; };
  return element("article", {
    class: "card", tabindex: 0, style: `--chip: var(--${c.state})`, onclick: open,
    onkeydown: e => { if (e.key === "Enter") open(); },
  },
    element("h2", {}, element("span", { class: "name" }, c.name), element("span", { class: "state" }, WORDS[c.state])),
    element("div", { class: "about", title: c.about }, c.about || "\u00a0"),
    p ? trio(c, p) : c.pictures.length ? single(c) : element("div", { class: "trio none" }, texts.length ? texts[0].kind : c.state === "left_out" ? "not run" : "no picture"),
    element("div", { class: "numbers" }, numbers(c, p)),
    c.why.length ? element("div", { class: "why", title: c.why.join("\n") }, c.why.join("; ")) : null);
}
