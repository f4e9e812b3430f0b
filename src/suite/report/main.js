// What starts the page: its heading, filters, keys, and the case that its address names.
"use strict";
function start() {
  $("title").textContent = DATA.title;
  const date = new Date(1000 * DATA.started);
  $("summary").textContent = `${DATA.cases.length} cases in ${time(DATA.seconds)}, ${DATA.jobs} at a time · ${DATA.program}` +
    `${DATA.gpu ? " · " + DATA.gpu : ""} · ${date.toISOString().slice(0, 16).replace("T", " ")} UTC`;
  $("faults").append(...DATA.faults.map(f => element("li", {}, f)), ...DATA.notes.map(f => element("li", { class: "note" }, f)));
  for (const [state, word] of Object.entries(WORDS)) {
    const n = DATA.cases.filter(c => c.state === state).length;
    if (!n) continue;
    const chip = element("button", { class: "chip", style: `--chip: var(--${state})`, "data-state": state, onclick: () => {
      filters.states.has(state) ? filters.states.delete(state) : filters.states.add(state);
      refresh();
    } }, `${n} ${word}`);
    $("states").append(chip);
  }
  const choose = (id, key, values, all) => {
    const count = v => DATA.cases.filter(c => key === "area" ? c.area === v : c.pairs.some(p => p.pair === v)).length;
    $(id).append(element("option", { value: "" }, all), ...values.map(v => element("option", { value: v }, `${v} (${count(v)})`)));
    $(id).onchange = () => { filters[key] = $(id).value; refresh(); };
  };
  choose("area", "area", [...new Set(DATA.cases.map(c => c.area))].sort(), "all");
  choose("pair", "pair", [...new Set(DATA.cases.flatMap(c => c.pairs.map(p => p.pair)))].sort(), "the worst");
  $("order").onchange = () => { filters.order = $("order").value; refresh(); };
  $("search").oninput = () => { filters.text = $("search").value; refresh(); };
  $("thumb").oninput = () => document.documentElement.style.setProperty("--thumb", $("thumb").value + "px");
  $("reset").onclick = () => {
    Object.assign(filters, { states: new Set(), area: "", pair: "", text: "" });
    for (const id of ["area", "pair", "search"]) $(id).value = "";
    refresh();
  };
  new IntersectionObserver(e => { if (e[0].isIntersecting && made < shown.length) more(); }, { rootMargin: "1200px" }).observe($("more"));
  refresh();
  follow();
}

// The address names the open case, so that it can be sent to somebody.
function follow() {
  const name = decodeURIComponent(location.hash.slice(1));
  const c = DATA.cases.find(c => c.name === name);
  if (c) openCase(c); else closeCase();
}

function key(e) {
  if (e.ctrlKey || e.metaKey || e.altKey) return;
  if (["INPUT", "SELECT"].includes(document.activeElement.tagName)) {
    if (e.key === "Escape") document.activeElement.blur();
    return;
  }
  if (!view.c) {
    if (e.key === "/") {
      e.preventDefault();
      $("search").focus();
    }
    return;
  }
  const mode = MODES[Number(e.key) - 1];
  if (mode) setMode(mode[0]);
  else if (e.key === "Escape") location.hash = "";
  else if (e.key === "ArrowRight") neighbour(1);
  else if (e.key === "ArrowLeft") neighbour(-1);
  else if (e.key === "f") fit();
  else if (e.key === "0") zoomTo(1 / devicePixelRatio);
  else if (e.key === "+" || e.key === "-") {
    view.gain = Math.min(64, Math.max(1, e.key === "+" ? view.gain * 2 : view.gain / 2));
    paint();
  } else if (e.key === " ") flip(null, true);
  else return;
  e.preventDefault();
}

addEventListener("hashchange", follow);
addEventListener("keydown", key);
addEventListener("keyup", e => { if (e.key === " " && view.c) flip(null, false); });
addEventListener("resize", () => { if (view.c) { if (view.fitted) fitQuietly(); draw(); } });
start();
