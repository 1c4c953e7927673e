// The page: sliders, methods, motion, curves and numbers of one system.
const LONGEST = 10; // seconds in which a run is shown
const POINTS = 2000; // least number of points of a curve
const MOST_STEPS = 100000;
const SCENES = 60; // from which the frame of the motion is found
const NONE = "none";

const byId = (id) => document.getElementById(id);
function made(kind, fields, ...inside) {
  const found = Object.assign(document.createElement(kind), fields);
  found.append(...inside);
  return found;
}

const state = {
  p: Float64Array.from(DATA.sliders, (one) => one.value), y0: null, tEnd: DATA.tEnd,
  chosen: { ...VARIANTS[0].chosen }, ways: DATA.ways.map((way) => ({ ...way })),
  events: new Set(DATA.events.filter((one) => one.terminal).map((one) => one.name)),
  component: DATA.component, across: DATA.across, upwards: DATA.upwards, value: DATA.value,
  kept: DATA.kept, playing: true, speed: 1, trail: true, time: 0, runs: [], dirty: true,
  dragged: location.hash.length > 1,
};

function variant() {
  return VARIANTS.find((one) => Object.entries(state.chosen).every(([k, v]) => one.chosen[k] === v));
}

function watched() {
  return DATA.events.map((one, index) => ({
    name: one.name, index, direction: one.direction, terminal: one.ends,
  }));
}

// -- solving

function start() {
  return state.y0 ? Float64Array.from(state.y0) : startOf(variant(), state.p);
}

function compute() {
  state.dirty = false;
  const y0 = start();
  if (!y0) {
    say("The start is not defined for these values.");
    return;
  }
  const asked = { variant: variant(), p: state.p, y0, tf: state.tEnd, most: MOST_STEPS, events: watched() };
  const runs = state.ways.filter((way) => way.method !== NONE).map((way) => ({
    way, ...solve({ ...asked, method: METHODS[way.method], rtol: way.rtol, step: way.step }),
  }));
  for (const run of runs) sample(run);
  const wrong = runs.find((run) => run.message);
  say(wrong ? `${wrong.way.method} ends at t = ${shown(last(wrong.t), 4)} s. ${wrong.message}`
    : runs.length ? pulls(runs[0]) : "");
  state.runs = runs;
  if (state.time > end()) rewind();
  stage && frame();
  trails.length = 0;
  trailed = -1;
  drawCurves();
  tell();
  remember();
}

const last = (list) => list[list.length - 1];
const end = () => (state.runs.length ? last(state.runs[0].t) : state.tEnd);

// Times and states of the curves of a run: within each step as many as the eye needs.
function sample(run) {
  const n = DATA.states.length, steps = run.spans.length;
  const each = Math.max(1, Math.ceil(POINTS / Math.max(steps, 1)));
  const count = steps * each + 1, t = new Float64Array(count), y = rows(n, count), at = zeros(n);
  for (let k = 0, i = 0; k <= steps; k++) {
    if (k === steps) {
      put(last(run.t), last(run.y), i);
      break;
    }
    const [from, h] = run.spans[k], to = stepEnd(run, k);
    for (let j = 0; j < each; j++, i++) {
      const time = from + (to - from) * j / each;
      put(time, polynomial(run.dense[k], (time - from) / h, at), i);
    }
  }
  run.curve = { t, y };
  function put(time, values, i) {
    t[i] = time;
    for (let j = 0; j < n; j++) y[j][i] = values[j];
  }
}
function stepEnd(run, k) {
  const next = run.spans[k + 1], [from, h] = run.spans[k];
  return Math.min(next ? next[0] : last(run.t), from + h);
}

// A function of a run along times and states, NaN where it is not defined.
function along(of, times, states, run, name) {
  const out = [0], found = new Float64Array(times.length), p = state.p;
  for (let i = 0; i < times.length; i++) {
    found[i] = of(times[i], states(i), p, out) ? NaN : out[0];
  }
  for (const phase of run.phases) {
    const none = DATA.noneIn[phase.name] || [];
    if (!none.includes(name)) continue;
    for (let i = 0; i < times.length; i++) {
      if (times[i] > phase.begin && times[i] <= phase.end) found[i] = 0;
    }
  }
  return found;
}

// A sentence if a contact pulls, as Python warns.
function pulls(run) {
  const t = Float64Array.from(run.t);
  for (const [index, body] of DATA.pushing) {
    const of = variant().values[index];
    if (!of) continue;
    const found = along(of, t, (i) => run.y[i], run, DATA.values[index].name);
    const size = found.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    const at = found.findIndex((x) => x < -1e-9 * size);
    if (at >= 0) {
      return `The normal force ${DATA.values[index].name} is negative from about t = ${
        shown(t[at], 4)} s: the contact pulls. ${body} would leave a surface there.`;
    }
  }
  return "";
}

// The change of an invariant at the steps, relative to its value at the start.
function change(run, index) {
  const t = Float64Array.from(run.t);
  const found = along(variant().values[index], t, (i) => run.y[i], run, DATA.values[index].name);
  const first = found[0], size = Math.abs(first) || 1;
  for (let i = 0; i < found.length; i++) found[i] = (found[i] - first) / size;
  return { t, change: found, relative: first !== 0 };
}

// -- curves

const plots = {};
function drawCurves() {
  const { component, across, upwards, runs } = state, { states } = DATA;
  const name = (i) => `${states[i].letters}${states[i].unit ? ` (${states[i].unit})` : ""}`;
  const colour = (k) => DATA.colours.ways[k];
  const index = (run) => state.ways.indexOf(run.way);
  const curve = (run, x, y, whole) => ({ x, y, whole, colour: colour(index(run)), dash: index(run) > 0 });
  const marks = [];
  for (const run of runs) {
    DATA.events.forEach((one, i) => {
      if (!state.events.has(one.name)) return;
      for (const { t, y } of run.found[i]) marks.push({ t, y, colour: colour(index(run)) });
    });
  }
  plots.component.show(runs.map((run) => curve(run, run.curve.t, run.curve.y[component], true)),
    marks.map((one) => ({ x: one.t, y: one.y[component], colour: one.colour })),
    ["t (s)", name(component)]);
  if (plots.phase) {
    const y0 = runs.length ? runs[0].y[0] : start();
    plots.phase.at = [y0[across], y0[upwards]];
    plots.phase.show(runs.map((run) => curve(run, run.curve.y[across], run.curve.y[upwards])),
      marks.map((one) => ({ x: one.y[across], y: one.y[upwards], colour: one.colour })),
      [name(across), name(upwards)], states[across].unit === states[upwards].unit);
  }
  if (plots.kept) {
    const found = runs.map((run) => change(run, state.kept));
    plots.kept.show(runs.map((run, k) => curve(run, found[k].t, found[k].change, true)), [],
      ["t (s)", found.some((one) => one.relative) ? "relative change" : "change"]);
    runs.forEach((run, k) => {
      run.drift = found[k].change.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    });
  }
  if (plots.value) {
    const about = DATA.values[state.value], of = variant().values[state.value];
    const values = runs.map((run) => {
      const at = zeros(states.length), { t, y } = run.curve;
      return along(of, t, (i) => { for (let j = 0; j < at.length; j++) at[j] = y[j][i]; return at; },
        run, about.name);
    });
    plots.value.show(runs.map((run, k) => curve(run, run.curve.t, values[k], true)), [],
      ["t (s)", about.unit || "value"]);
  }
}

// -- motion

let stage = null, trailed = -1;
const trails = [];
const coordinates = (run, time) => {
  const y = run.at(Math.min(time, last(run.t)));
  return variant().picture(Math.min(time, last(run.t)), y, state.p, run.picture) ? null : run.picture;
};
function frame() {
  const pictures = [];
  for (const run of state.runs) {
    run.picture = zeros(stage.scene.size);
    for (let k = 0; k <= SCENES; k++) {
      const found = coordinates(run, last(run.t) * k / SCENES);
      if (found) pictures.push(found.slice());
    }
  }
  if (pictures.length && !held) stage.frame(pictures);
}

function extendTrails(time) {
  const step = end() / 600, from = trailed < 0 ? time : trailed;
  state.runs.forEach((run, k) => {
    const trail = trails[k] || (trails[k] = []), at = stage.scene.trail;
    const count = Math.min(Math.ceil((time - from) / step), 60);
    for (let i = trailed < 0 ? 0 : 1; i <= Math.max(count, trailed < 0 ? 0 : 1); i++) {
      const found = coordinates(run, from + (time - from) * (count ? i / count : 1));
      if (found) trail.push(found[at], found[at + 1]);
    }
    if (trail.length > 2000) trail.splice(0, trail.length - 2000);
  });
  trailed = time;
}

let before = performance.now(), held = false;
function tick(now) {
  const passed = Math.max(0, Math.min((now - before) / 1000, 0.1)); // `now` may be before loading
  before = now;
  if (state.dirty) {
    const begun = performance.now();
    compute();
    state.milliseconds = performance.now() - begun;
    state.updates = (state.updates || 0) + 1;
  }
  if (state.playing && !held && state.runs.length) {
    state.time += passed * state.speed * Math.max(1, end() / LONGEST);
    if (state.time > end()) rewind();
    byId("time").value = String(1000 * state.time / end());
  }
  if (stage && state.runs.length) {
    extendTrails(state.time);
    const pictures = state.runs.map((run) => coordinates(run, state.time)).map((one) => one || []);
    stage.draw(pictures, state.trail ? trails : []);
    byId("clock").textContent = [`t = ${state.time.toFixed(2)} s`, stage.scene.note, asBefore()]
      .filter(Boolean).join(", ");
    placeHandles(pictures[0]);
  } else if (state.runs.length) {
    byId("clock").textContent = `t = ${state.time.toFixed(2)} s`;
  }
  requestAnimationFrame(tick);
}
// A note where shapes of the picture do not follow a slider.
function asBefore() {
  const moved = DATA.scene.still.map((name) => DATA.sliders.findIndex((one) => one.name === name))
    .filter((i) => state.p[i] !== DATA.sliders[i].value);
  return moved.length ? `shapes as for ${moved.map((i) => `${DATA.sliders[i].name} = ${
    shown(DATA.sliders[i].value, 4)}`).join(", ")}` : "";
}
function rewind() {
  state.time = 0;
  trails.length = 0;
  trailed = -1;
}

// Handles on the masses: a drag changes the start, so that the mass is under the finger.
const handles = [];
function placeHandles(picture) {
  const width = stage.canvas.clientWidth, height = stage.canvas.clientHeight;
  handles.forEach(({ element, at }, k) => {
    const x = stage.x(picture[at]) / stage.ratio, y = stage.y(picture[at + 1]) / stage.ratio;
    element.style.left = `${Math.min(Math.max(x, 8), width - 8)}px`;
    element.style.top = `${Math.min(Math.max(y, 8), height - 8)}px`;
    if (k === 0 && hint) {
      hint.style.left = element.style.left;
      hint.style.top = element.style.top;
    }
  });
}
let hint = null;

function dragTo(at, px, py) {
  const [x, y] = stage.inverse(px, py), found = nearest(at, x, y);
  if (!found) return;
  state.y0 = Array.from(found);
  state.dragged = true;
  changed();
}

// The start near the present one with a point of the picture at (x, y): Gauss and Newton.
function nearest(at, x, y) {
  const { picture, project } = variant(), n = DATA.states.length, m = DATA.coordinates;
  const out = zeros(stage.scene.size), place = (w) => (picture(0, w, state.p, out) ? null : [out[at], out[at + 1]]);
  let w = start();
  if (!w) return null;
  for (let turn = 0; turn < 12; turn++) {
    const here = place(w);
    if (!here) return null;
    const a = [[], []];
    for (let j = 0; j < m; j++) {
      const h = 1e-6 * Math.max(1, Math.abs(w[j])), moved = w.slice();
      moved[j] += h;
      const there = place(moved);
      if (!there) return null;
      a[0].push((there[0] - here[0]) / h);
      a[1].push((there[1] - here[1]) / h);
    }
    const rx = x - here[0], ry = y - here[1];
    const xx = dot(a[0], a[0]), xy = dot(a[0], a[1]), yy = dot(a[1], a[1]);
    const damping = 1e-3 * (xx + yy) + 1e-12, det = (xx + damping) * (yy + damping) - xy * xy;
    const u = ((yy + damping) * rx - xy * ry) / det, v = ((xx + damping) * ry - xy * rx) / det;
    for (let j = 0; j < m; j++) {
      const step = a[0][j] * u + a[1][j] * v;
      w[j] += DATA.states[j].unit === "rad" ? Math.max(-0.7, Math.min(0.7, step)) : step;
    }
    if (project) {
      const moved = zeros(n);
      if (project(0, w, state.p, moved)) return null;
      w = moved;
    }
  }
  return w.map((value) => Number(value.toPrecision(6)));
}

// -- numbers

function tell() {
  const { runs } = state, kept = DATA.values[state.kept];
  const head = made("tr", {}, made("th", {}), ...runs.map((run) => made("th", {
    scope: "col", textContent: label(run.way), style: `color:${DATA.colours.ways[state.ways.indexOf(run.way)]}`,
  })));
  const row = (name, cells) => made("tr", {}, made("td", { textContent: name }),
    ...cells.map((text) => made("td", { textContent: text })));
  const body = [
    row("steps", runs.map((run) => String(run.accepted))),
    row("evaluations", runs.map((run) => String(run.nfev))),
    row("time of the solve", runs.map((run) => `${run.milliseconds.toFixed(1)} ms`)),
  ];
  if (kept) body.push(row(`largest change of ${kept.label}`, runs.map((run) => shown(run.drift, 2))));
  DATA.events.forEach((one, i) => {
    if (state.events.has(one.name)) {
      body.push(row(`${words(one.name)} at t =`, runs.map(({ found }) => times(found[i].map(({ t }) => t)))));
    }
  });
  const answers = DATA.derived.map((one, k) => {
    const value = answer(one, k);
    const told = typeof value === "string" ? value : shown(value, 6);
    return row(words(one.name), [told === "–" ? told : `${told} ${one.unit}`]);
  });
  byId("numbers").replaceChildren(made("thead", {}, head), made("tbody", {}, ...body, ...answers));
  DATA.sliders.forEach((one, i) => { if (one.initial) sliders[i].dim(state.y0 !== null); });
  runs.forEach((run) => {
    const place = document.querySelectorAll(".way .drift")[state.ways.indexOf(run.way)];
    place.textContent = kept ? `${kept.label} changes by ${shown(run.drift, 2)}` : `${run.accepted} steps`;
  });
}
const words = (name) => name.replace(/_/g, " ");
const label = (way) => (METHODS[way.method].fixed ? `${way.method}, h = ${shown(way.step, 3)} s`
  : `${way.method}, tolerance ${shown(way.rtol, 2)}`);
const times = (list) => (list.length ? `${list.slice(0, 3).map((t) => shown(t, 5)).join(", ")}${
  list.length > 3 ? ` … (${list.length} times)` : ""} s` : "–");

const FIRST_ONLY = "for the first values only";

function answer(one, k) {
  if (state.y0) return "–";
  if ("fixed" in one) {
    if (one.fixed === null) return "–";
    return DATA.sliders.every((slider, i) => state.p[i] === slider.value) ? one.fixed : FIRST_ONLY;
  }
  const out = [0];
  return variant().derived[k](0, zeros(DATA.states.length), state.p, out) ? NaN : out[0];
}

function say(sentence) { byId("said").textContent = sentence; }

// -- widgets

function changed() { state.dirty = true; }

function number(text) {
  const found = Number(text.trim().replace("−", "-"));
  if (text.trim() !== "" && Number.isFinite(found)) return found;
  const comma = /^\s*[-+]?\d+,\d+\s*$/.test(text) ? `; with a point it is ${text.trim().replace(",", ".")}` : "";
  say(`“${text}” is no number${comma}.`);
  return null;
}

function slider(about, value, moved) {
  const text = made("input", { type: "text", inputMode: "decimal", value: shown(value, 6) });
  const range = made("input", { type: "range", min: about.low, max: about.high, step: about.step, value });
  range.setAttribute("aria-label", about.title);
  text.setAttribute("aria-label", `${about.title}, as a number`);
  const root = made("div", { className: "slider" },
    made("div", { className: "top" }, made("span", { textContent: about.title }), text), range);
  const take = (x, from) => {
    if (about.positive && !(x > 0)) {
      say(`${about.title} must be greater than zero.`);
      return;
    }
    if (from !== range) {
      range.min = String(Math.min(Number(range.min), x));
      range.max = String(Math.max(Number(range.max), x));
      range.value = String(x);
    }
    if (from !== text) text.value = String(x);
    say("");
    moved(x);
    changed();
  };
  range.addEventListener("input", () => take(Number(Number(range.value).toPrecision(10)), range));
  text.addEventListener("change", () => {
    const x = number(text.value);
    if (x !== null) take(x, text);
  });
  return { root, set: (x) => { range.value = String(x); text.value = String(x); },
    dim: (is) => {
      root.classList.toggle("off", is);
      root.title = is ? "The start was dragged: a move of this slider, or Reset, ends that." : "";
    } };
}

function select(names, value, chosen, title) {
  const found = made("select", {}, ...names.map(([key, text]) => made("option", { value: key, textContent: text })));
  found.value = value;
  found.setAttribute("aria-label", title);
  found.addEventListener("change", () => { chosen(found.value); changed(); });
  return found;
}

const sliders = [], choices = {}, wayWidgets = [];
function buildSide() {
  const side = byId("side");
  for (const [name, options] of Object.entries(DATA.choices)) {
    choices[name] = select(options.map((one) => [one, one]), state.chosen[name],
      (one) => { state.chosen[name] = one; }, name);
    side.append(made("label", { className: "slider" }, `${name} `, choices[name]));
  }
  DATA.sliders.forEach((about, i) => {
    const one = slider(about, state.p[i], (x) => {
      state.p[i] = x;
      if (about.initial && state.y0) {
        state.y0 = null;
        rewind();
      }
    });
    sliders.push(one);
    side.append(one.root);
  });
  const endSlider = slider(DATA.end, state.tEnd, (x) => { state.tEnd = x; });
  sliders.push(endSlider);
  side.append(endSlider.root);
}

function buildWays() {
  const known = DATA.methods.map((name) => [name, name]);
  state.ways.forEach((way, k) => {
    const method = select(k ? [[NONE, "none"], ...known] : known, way.method,
      (name) => { way.method = name; show(); }, k ? "second method" : "method");
    const about = made("span", {}), accuracy = made("input", { type: "range", step: 1 });
    const drift = made("span", { className: "drift" });
    const list = () => (METHODS[way.method].fixed ? DATA.steps : DATA.tolerances);
    const value = () => (METHODS[way.method].fixed ? way.step : way.rtol);
    function show() {
      accuracy.disabled = way.method === NONE;
      if (way.method === NONE) {
        about.textContent = "compare with another method";
        drift.textContent = "";
        return;
      }
      const { fixed, words: text } = METHODS[way.method];
      accuracy.min = 0;
      accuracy.max = list().length - 1;
      accuracy.value = String(nearestIndex(list(), value()));
      method.title = text;
      about.textContent = fixed ? `step ${shown(way.step, 3)} s` : `tolerance ${shown(way.rtol, 2)}`;
      accuracy.setAttribute("aria-label", fixed ? "step" : "tolerance");
    }
    accuracy.addEventListener("input", () => {
      const found = list()[Number(accuracy.value)];
      if (METHODS[way.method].fixed) way.step = found; else way.rtol = found;
      show();
      changed();
    });
    const colour = DATA.colours.ways[k];
    byId("ways").append(made("fieldset", { className: "way", style: `border-left-color:${colour}` },
      made("legend", { textContent: k ? "second (dashed)" : "method", style: `color:${colour}` }),
      method, made("label", {}, about, accuracy), drift));
    accuracy.style.accentColor = colour;
    drift.style.color = colour;
    wayWidgets.push({ set: () => { method.value = way.method; show(); } });
    show();
  });
}
function nearestIndex(list, value) {
  let best = 0;
  list.forEach((one, i) => {
    if (Math.abs(Math.log(one / value)) < Math.abs(Math.log(list[best] / value))) best = i;
  });
  return best;
}

function buildPlots() {
  const component = (key, title) => select(
    DATA.states.map((one, i) => [i, one.letters]), state[key], (i) => { state[key] = Number(i); }, title);
  const head = (id, ...inside) => byId(id).querySelector(".head").append(...inside);
  const plot = (id, height) => new Plot(byId(id).querySelector(".curves"), height);
  plots.component = plot("component", 220);
  head("component", component("component", "component"), " against time");
  if (DATA.states.length > 1) {
    plots.phase = plot("phase", 300);
    head("phase", "phase plane: ", component("upwards", "upwards"), " over ", component("across", "across"));
    plots.phase.drag((x, y) => {
      const y0 = start();
      y0[state.upwards] = Number(y.toPrecision(5));
      y0[state.across] = Number(x.toPrecision(5));
      state.y0 = Array.from(y0);
      changed();
    });
  }
  const listed = (groups) => DATA.values.map((one, i) => [i, one]).filter(
    ([i, one]) => groups.includes(one.group) && VARIANTS.every((each) => each.values[i]));
  const options = (list) => list.map(([i, one]) => [i, one.label]);
  const kept = listed(["invariants", "constraints"]);
  if (kept.length) {
    plots.kept = plot("kept", 170);
    head("kept", "change of ", select(options(kept), state.kept, (i) => { state.kept = Number(i); }, "what is kept"));
  }
  const values = listed(["quantities", "invariants", "constraints"]);
  if (values.length) {
    plots.value = plot("value", 200);
    head("value", select(options(values), state.value, (i) => { state.value = Number(i); }, "quantity"), " against time");
  }
  if (DATA.events.length) {
    byId("events").append("marked: ", ...DATA.events.map((one) => {
      const box = made("input", { type: "checkbox", checked: state.events.has(one.name) });
      box.addEventListener("change", () => {
        if (box.checked) state.events.add(one.name); else state.events.delete(one.name);
        changed();
      });
      return made("label", {}, box, ` ${words(one.name)}`);
    }));
  }
}

function buildMotion() {
  const pause = byId("pause");
  pause.addEventListener("click", () => {
    state.playing = !state.playing;
    pause.textContent = state.playing ? "❚❚ Pause" : "▶ Play";
  });
  byId("time").addEventListener("input", (event) => {
    rewind();
    state.time = Number(event.target.value) / 1000 * end();
    if (state.playing) pause.click();
  });
  byId("speed").addEventListener("change", (event) => { state.speed = Number(event.target.value); });
  byId("trail").addEventListener("change", (event) => { state.trail = event.target.checked; });
  byId("reset").addEventListener("click", reset);
  if (!DATA.scene) return;
  stage = new Stage(byId("canvas"), DATA.scene, DATA.colours);
  let at = 0;
  const seen = new Set();
  for (const [kind, n] of DATA.scene.parts) {
    if (kind === "trail") DATA.scene.trail = at;
    if (kind === "points" || (kind === "trail" && !seen.size)) {
      const place = at;
      seen.add(place);
      const element = handle(byId("stage"), "drag the start", (px, py) => dragTo(place, px, py),
        (begins) => { held = begins; if (begins) { rewind(); hint && hint.remove(); hint = null; } });
      handles.push({ element, at });
    }
    at += 2 * n;
  }
  DATA.scene.size = at;
  if (!state.dragged) {
    hint = made("p", { className: "hint", textContent: "drag me" });
    byId("stage").append(hint);
  }
}

function reset() {
  DATA.sliders.forEach((one, i) => { state.p[i] = one.value; });
  state.chosen = { ...VARIANTS[0].chosen };
  state.ways.forEach((way, k) => Object.assign(way, DATA.ways[k]));
  state.tEnd = DATA.tEnd;
  state.y0 = null;
  show();
  rewind();
  changed();
}

function show() {
  DATA.sliders.forEach((one, i) => sliders[i].set(state.p[i]));
  last(sliders).set(state.tEnd);
  for (const [name, one] of Object.entries(choices)) one.value = state.chosen[name];
  for (const one of wayWidgets) one.set();
}

// -- the link, and files

function remember() {
  const words = new URLSearchParams();
  DATA.sliders.forEach((one, i) => { if (state.p[i] !== one.value) words.set(one.name, state.p[i]); });
  for (const [name, one] of Object.entries(state.chosen)) {
    if (one !== VARIANTS[0].chosen[name]) words.set(`choice.${name}`, one);
  }
  if (state.tEnd !== DATA.tEnd) words.set("t.end", state.tEnd);
  if (state.y0) words.set("y0", state.y0.join(" "));
  state.ways.forEach((way, k) => {
    for (const key of ["method", "rtol", "step"]) {
      if (way[key] !== DATA.ways[k][key]) words.set(`${key}.${k}`, way[key]);
    }
  });
  const text = words.toString();
  history.replaceState(null, "", text ? `#${text}` : location.pathname + location.search);
}

function recall() {
  const words = new URLSearchParams(location.hash.slice(1));
  const value = (name, set) => {
    const found = Number(words.get(name));
    if (words.has(name) && Number.isFinite(found)) set(found);
  };
  DATA.sliders.forEach((one, i) => value(one.name, (x) => { if (x > 0 || !one.positive) state.p[i] = x; }));
  for (const [name, options] of Object.entries(DATA.choices)) {
    if (options.includes(words.get(`choice.${name}`))) state.chosen[name] = words.get(`choice.${name}`);
  }
  value("t.end", (x) => { if (x > 0) state.tEnd = x; });
  state.ways.forEach((way, k) => {
    const method = words.get(`method.${k}`);
    if (DATA.methods.includes(method) || (k && method === NONE)) way.method = method;
    for (const key of ["rtol", "step"]) value(`${key}.${k}`, (x) => { if (x > 0) way[key] = x; });
  });
  const y0 = (words.get("y0") || "").split(" ").map(Number);
  if (words.has("y0") && y0.length === DATA.states.length && y0.every(Number.isFinite)) state.y0 = y0;
}

function save(name, blob) {
  const link = made("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function table() {
  const run = state.runs[0], { t, y } = run.curve, at = zeros(DATA.states.length);
  const given = DATA.values.map((one, i) => [one, variant().values[i]]).filter(([, of]) => of);
  const values = given.map(([one, of]) => along(of, t, (i) => {
    for (let j = 0; j < at.length; j++) at[j] = y[j][i];
    return at;
  }, run, one.name));
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
  const names = ["t (s)", ...DATA.states.map((one) => `${one.name} (${one.unit})`),
    ...given.map(([one]) => `${one.name} (${one.unit})`)];
  const lines = [names.map(quoted).join(",")];
  for (let i = 0; i < t.length; i++) {
    lines.push([t[i], ...y.map((one) => one[i]), ...values.map((one) => one[i])].join(","));
  }
  return `${lines.join("\n")}\n`;
}

function picture() {
  const canvases = [...document.querySelectorAll("#stage canvas, .plot canvas")].filter(
    (one) => one.width > 1 && (stage || one.id !== "canvas"));
  const width = Math.max(...canvases.map((one) => one.width));
  const sizes = canvases.map((one) => [width, one.height * width / one.width]);
  const whole = made("canvas", { width, height: 40 + sizes.reduce((sum, [, h]) => sum + h + 10, 0) });
  const context = whole.getContext("2d");
  context.fillStyle = "#fff";
  context.fillRect(0, 0, whole.width, whole.height);
  context.fillStyle = "#222";
  context.font = "20px system-ui, sans-serif";
  context.fillText(`${DATA.title}: ${state.runs.map((run) => label(run.way)).join("; ")}`, 10, 26);
  let top = 40;
  canvases.forEach((one, k) => {
    context.drawImage(one, 0, top, ...sizes[k]);
    top += sizes[k][1] + 10;
  });
  return whole;
}

function buildFiles() {
  byId("png").addEventListener("click", () => picture().toBlob((blob) => save(`${DATA.name}.png`, blob)));
  byId("csv").addEventListener("click", () => save(`${DATA.name}.csv`, new Blob([table()], { type: "text/csv" })));
  byId("link").addEventListener("click", async () => {
    remember();
    try {
      await navigator.clipboard.writeText(location.href);
      byId("link").textContent = "Link copied";
    } catch {
      prompt("The link to these values:", location.href);
    }
    setTimeout(() => { byId("link").textContent = "Copy link"; }, 2000);
  });
}

recall();
buildMotion();
buildSide();
buildWays();
buildPlots();
buildFiles();
window.addEventListener("hashchange", () => { recall(); show(); changed(); });
requestAnimationFrame(tick);

// For tests: a solve without drawing.
window.fastdyn = { state, solve, startOf, variant, METHODS, DATA, VARIANTS, changed, watched, table };
