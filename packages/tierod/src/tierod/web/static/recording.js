// A recording: findings over time, signals in panels, two recordings, measuring, export.
import { html, stack, useCallback, useEffect, useLayoutEffect, useMemo, useRef, useState } from "./html.js";
import { get, post, query, site as served, windows } from "./api.js";
import { go, link, set } from "./address.js";
import { colour, nearest, picture, TimeChart } from "./chart.js";
import { clock, figure, Loading, sentence, Trouble, useFetched, useJob, Work } from "./parts.js";
import { added, names, parse, usual, without, write } from "./panels.js";
import { Remarks, shared, TimeAxis, Verdict } from "./findings.js";
import { Tree } from "./tree.js";

/** What is kept of a recording; what is not there yet is worked out by a job. */
export function useAnalysed(file, vehicle) {
  const [job, begin] = useState(null);
  const state = useFetched((signal) => (file ? get("/api/opened", { file }, signal) : null), [file]);
  const followed = useJob(job);
  const known = state.data && state.data.state, there = state.data || {};
  const fresh = known && known.series && (known.result || (known.vehicle === "none" && !vehicle)) && (!vehicle || vehicle === known.vehicle);
  const start = () => post("/api/analyses", { file, vehicle: vehicle || "" }).then(begin, (error) => begin({ id: "", state: "failed", text: error.message }));
  useEffect(() => { begin(null); }, [file, vehicle]);
  useEffect(() => { if (known && !fresh) start(); }, [known, file, vehicle]);
  const found = (followed && followed.found) || {};
  const done = followed && followed.state === "done";
  const seriesKey = found.series || (known && known.series) || "";
  const resultKey = done ? found.result : fresh ? known.result : "";
  const series = useFetched((signal) => (!seriesKey ? null : there.series && there.series.key === seriesKey ? there.series : get(`/api/series/${seriesKey}`, {}, signal)), [seriesKey]);
  const result = useFetched((signal) => (!resultKey ? null : there.result && there.result.key === resultKey ? there.result : get(`/api/results/${resultKey}`, {}, signal)), [resultKey]);
  return { state, job: followed, start, series, result, seriesKey, resultKey, why: done ? found.why : fresh && !known.result ? known.why : "" };
}

export function Recording({ address }) {
  if (address.report) return stack`<${Report} place=${address.report} />`;
  if (!address.file) return stack`<p>Choose a recording from the <a href="/">list</a>.</p>`;
  return stack`<${Bench} key=${address.file} address=${address} />`;
}

function Report({ place }) {
  const [key, monitor] = place.split("/");
  const source = `/api/results/${encodeURIComponent(key)}/report/${encodeURIComponent(monitor || "")}`;
  return stack`<h1>Report of ${monitor}</h1><p class="tools"><button onClick=${() => history.back()}>Back</button> <a class="button" href=${source} target="_blank" rel="noopener">In a window of its own</a> <a class="button" href=${source} download=${`${monitor}.html`}>Download</a></p>
    <iframe class="report" src=${source} title=${`Report of ${monitor}`} sandbox="allow-scripts allow-downloads allow-popups"></iframe>`;
}

function Bench({ address }) {
  const one = useAnalysed(address.file, address.vehicle), other = useAnalysed(address.over || "", address.vehicle);
  const series = one.series.data, result = one.result.data;
  const title = address.file.split("/").pop(), warnings = (series && series.facts.warnings) || [];
  return stack`<div class="row"><h1 class="grow">${title}</h1><${VehicleChoice} address=${address} now=${result && result.vehicle} /></div>
    ${one.state.error && html`<${Trouble} error=${one.state.error} again=${one.state.again} />`}
    <${Work} job=${one.job} again=${one.start} />
    ${one.job && one.job.state === "failed" && html`<p>Signals under other names, or a bus log without database? <a href=${link("new", { file: address.file })}>Choose them under “New recording”</a>.</p>`}
    ${one.why && html`<p class="note">No verdict: ${sentence(one.why)}</p>`}
    ${one.state.data && one.state.data.state.corrected && html`<p class="small">Read with the channel map or database that was chosen under <a href=${link("new", { file: address.file })}>“New recording”</a>.</p>`}
    ${address.over && html`<${Work} job=${other.job} again=${other.start} />`}
    <${Remarks} warnings=${warnings} file=${address.file} />
    ${series ? html`<${Charts} address=${address} series=${series} result=${result} over=${other.series.data} overResult=${other.result.data} />` : one.state.error || (one.job && one.job.state === "failed") ? "" : html`<${Loading} what="Reading the recording" />`}
    ${result && html`<${Verdicts} result=${result} file=${address.file} warnings=${warnings} />`}`;
}

function VehicleChoice({ address, now }) {
  const site = useFetched(served, []).data;
  if (!site) return null;
  const names = [...new Set([...(site.vehicle ? [site.vehicle] : []), ...site.vehicles])];
  return stack`<label class="tools"><span class="small">judged as</span><select onChange=${(e) => set({ vehicle: e.target.value }, true)} value=${address.vehicle || ""}>
    <option value="">${now && !address.vehicle ? now : site.vehicle ? site.vehicle.split("/").pop() : "as the recording names it"}</option>${names.map((each) => html`<option value=${each} selected=${address.vehicle === each}>${each.split("/").pop()}</option>`)}</select></label>
    ${now && html`<a class="button tools" href=${link("vehicle", { name: address.vehicle || now })}>Its parameters</a>`}`;
}

function Verdicts({ result, file, warnings }) {
  const common = shared(result.monitors, warnings), above = new Set([...common.keys(), ...warnings]);
  return stack`<h2>Verdicts, as ${result.vehicle}</h2><p class="small">A figure with ± has one standard deviation behind it; “95 %” and the bands of the charts are 95 % intervals.</p>${[...common].map(([text, names]) => html`<p class="note">${sentence(text)} <span class="small">(${[...names].join(", ")})</span></p>`)}
    <div class="cards">${Object.entries(result.monitors).map(([monitor, each]) => html`<${Verdict} key=${monitor} monitor=${monitor} each=${each} result=${result} above=${above} />`)}</div>
    ${Object.keys(result.not_run).length > 0 && html`<details class="card" open=${Object.keys(result.monitors).length === 0}><summary>Monitors that did not run (${Object.keys(result.not_run).length})</summary><ul>${Object.entries(result.not_run).map(([name, why]) => html`<li><b>${name}</b>: ${sentence(why)}</li>`)}</ul><p>Signals under other names? <a href=${link("new", { file })}>Correct the channel map</a>.</p></details>`}`;
}

const number = (text) => (text === undefined || text === "" ? NaN : +text);

function Charts({ address, series, result, over, overResult }) {
  const signals = useMemo(() => [...series.signals, ...(result ? result.signals : [])], [series, result]);
  const byName = useMemo(() => new Map(signals.map((each) => [each.name, each])), [signals]);
  const panels = (address.signals !== undefined ? parse(address.signals) : usual(signals, result)).map((p) => p.filter((n) => byName.has(n))).filter((p) => p.length);
  const span = series.span, [view, onView] = useView(address, span);
  const change = (next) => set({ signals: write(next) }, true);
  const place = useRef(null), wanted = names(panels);
  const shift = number(address.shift) || 0;
  const data = useWindows(series.key, result && result.key, wanted, byName, view, span);
  const overNames = over ? wanted.filter((n) => [...over.signals, ...(overResult ? overResult.signals : [])].some((s) => s.name === n)) : [];
  const overData = useWindows(over && over.key, overResult && overResult.key, overNames, byName, [view[0] - shift, view[1] - shift], over ? over.span : [0, 1]);
  const toggle = (name, into) => change(wanted.includes(name) ? without(panels, name) : added(panels, name, into ? panels.length - 1 : undefined));
  const measured = { a: number(address.a), b: number(address.b) };
  const tree = useMemo(() => html`<${Tree} signals=${signals} shown=${new Set(wanted)} onToggle=${toggle} />`, [signals, address.signals]);
  return stack`<div class="bench"><aside class="side card">${tree}</aside>
    <div ref=${place}>
      <${Tools} address=${address} series=${series} result=${result} over=${over} overResult=${overResult} wanted=${wanted} view=${view} span=${span} onView=${onView} place=${place} />
      ${series.signals.every((each) => each.count < 2) && html`<p class="note">Every signal has one sample at most: the recording broke off, or the export kept a single row. Record or export it again.</p>`}
      ${result && html`<${TimeAxis} result=${result} span=${span} view=${view} onView=${onView} />`}
      ${data.error && html`<${Trouble} error=${data.error} again=${data.again} />`}
      ${panels.map((panel, at) => html`<${Panel} key=${panel[0]} at=${at} panel=${panel} panels=${panels} byName=${byName} result=${result} data=${data.found} overData=${overData.found} shift=${shift} view=${view} onView=${onView} measured=${measured} change=${change} />`)}
      <div class="card panel target tools" onDragOver=${(e) => e.preventDefault()} onDrop=${(e) => { e.preventDefault(); const n = e.dataTransfer.getData("text/plain"); if (byName.has(n)) change(added(panels, n)); }}><span class="small">Drop a signal here for a panel of its own. Drag in a chart zooms, the wheel too; Shift-drag or arrow keys pan; double click shows all; keys a and b set the measuring cursors.</span></div>
      <${Measured} seriesKey=${series.key} result=${result} wanted=${wanted} byName=${byName} measured=${measured} />
    </div></div>`;
}

/** The stretch that is shown: it follows the hand at once, and the address a little later. */
function useView(address, span) {
  const named = clipped(number(address.from), number(address.to), span);
  const [now, put] = useState(named), timer = useRef(0), written = useRef("");
  const text = `${address.from || ""} ${address.to || ""}`;
  useEffect(() => { if (text !== written.current) { clearTimeout(timer.current); written.current = text; put(named); } }, [text]);
  const latest = useRef(now);
  latest.current = now;
  const onView = useCallback((from, to) => {
    const [a, b] = clipped(from, to, span), all = a <= span[0] && b >= span[1];
    put([a, b]);
    clearTimeout(timer.current);
    timer.current = setTimeout(() => {
      const next = { from: all ? "" : String(+a.toPrecision(12)), to: all ? "" : String(+b.toPrecision(12)) };
      written.current = `${next.from} ${next.to}`;
      set(next);
    }, 250);
  }, [span[0], span[1]]);
  useEffect(() => () => clearTimeout(timer.current), []);
  return [now, onView];
}

export function clipped(from, to, span) {
  let a = Number.isFinite(from) ? from : span[0], b = Number.isFinite(to) ? to : span[1];
  const least = Math.max((span[1] - span[0]) * 1e-7, 1e-4);
  if (b - a < least) { const m = (a + b) / 2; a = m - least / 2; b = m + least / 2; }
  const width = Math.min(b - a, span[1] - span[0] || 1);
  if (a < span[0]) { a = span[0]; b = a + width; }
  if (b > span[1]) { b = span[1]; a = b - width; }
  return [a, b];
}

/** Bins over the width of a chart; more of them are wanted once the window is widened. */
function useFineness() {
  const fineness = () => Math.min(Math.max(Math.round(0.5 * innerWidth), 300), 1300);
  const [now, put] = useState(fineness);
  useEffect(() => {
    let timer;
    const resized = () => { clearTimeout(timer); timer = setTimeout(() => put(fineness()), 150); };
    addEventListener("resize", resized);
    return () => { clearTimeout(timer); removeEventListener("resize", resized); };
  }, []);
  return now;
}

/** The stretches that the charts show, with a margin for panning; the picture before stays until they come. */
function useWindows(key, result, wanted, byName, view, span) {
  const [state, put] = useState({ found: new Map() });
  const [turn, again] = useState(0);
  const all = useMemo(() => {
    const set = new Set(wanted);
    for (const name of wanted) {
      if (byName.has(`${name}_standard_deviation`)) set.add(`${name}_standard_deviation`);
      const slash = name.indexOf("/");
      if (slash > 0 && byName.has(`${name.slice(0, slash)}/enabled`)) set.add(`${name.slice(0, slash)}/enabled`);
    }
    return [...set].slice(0, 60);
  }, [wanted.join("\n"), byName]);
  const fineness = useFineness();
  const held = useRef({}), asked = useRef(-Infinity), flying = useRef(new Set()), shown = useRef(0);
  const chosen = `${key}\n${result}\n${all.join("\n")}\n${turn}`;
  useLayoutEffect(() => () => { flying.current.forEach((stop) => stop.abort()); flying.current.clear(); }, [chosen]);
  useLayoutEffect(() => {
    if (!key || !all.length) { put({ found: new Map() }); return undefined; }
    const width = view[1] - view[0], have = held.current, same = have.chosen === chosen;
    if (same && have.from <= view[0] && have.to >= view[1] && have.width <= 1.3 * width && have.fineness >= 0.8 * fineness) return undefined;
    const margin = 0.5 * width, from = Math.max(view[0] - margin, span[0]), to = Math.min(view[1] + margin, span[1]);
    const points = Math.round(fineness * Math.min((to - from) / width, 2));
    const ask = () => {
      const begun = performance.now(), stop = new AbortController();
      asked.current = begun;
      flying.current.add(stop);
      windows(key, { name: all, result, start: Math.min(from, to), stop: to, points: Math.min(Math.max(points, 10), 9000) }, stop.signal).then(
        (found) => {
          if (begun < shown.current) return; // a later question was answered before
          shown.current = begun;
          held.current = { chosen, from: from <= span[0] ? -Infinity : from, to: to >= span[1] ? Infinity : to, width, fineness };
          put({ found });
        },
        (error) => { if (error.name !== "AbortError") put((before) => ({ ...before, error })); }).finally(() => flying.current.delete(stop));
    };
    // The first step of the hand is answered at once; while it goes on moving, questions keep a distance.
    const wait = same ? asked.current + 60 - performance.now() : 0;
    if (wait <= 0) { ask(); return undefined; }
    const timer = setTimeout(ask, wait);
    return () => clearTimeout(timer);
  }, [chosen, view[0], view[1], fineness]);
  return { ...state, again: () => again(turn + 1) };
}

const scaled = (values, factor) => (factor === 1 ? values : values.map((v) => (v === null ? null : v * factor)));

function curvesOf(panel, byName, data, overData, shift) {
  const found = [];
  panel.forEach((name, at) => {
    const each = byName.get(name), part = data.get(name), deviation = data.get(`${name}_standard_deviation`);
    if (part) {
      const lower = scaled(part.lower, each.factor), upper = part.exact ? lower : scaled(part.upper, each.factor);
      let band;
      if (deviation && deviation.time.length === part.time.length) {
        const half = deviation.upper.map((v) => (v === null ? null : 1.96 * each.factor * v));
        band = { lower: lower.map((v, i) => (v === null || half[i] === null ? null : v - half[i])), upper: upper.map((v, i) => (v === null || half[i] === null ? null : v + half[i])) };
      }
      found.push({ name, title: each.title, label: each.label, colour: colour(at), time: part.time, lower, upper, band });
    }
    const second = overData.get(name);
    const low = second && scaled(second.lower, each.factor);
    if (second) found.push({ name: `${name} (second)`, title: `${each.title} (second)`, label: each.label, colour: colour(at + 3), dashed: true, time: second.time.map((t) => t + shift), lower: low, upper: second.exact ? low : scaled(second.upper, each.factor) });
  });
  return found;
}

/** Limits that a verdict rests on, and the moments at which they were passed. */
function limitsOf(panel, byName, result) {
  const levels = [], moments = [];
  if (!result) return { levels, moments };
  for (const name of panel) {
    const slash = name.indexOf("/"), each = byName.get(name), scale = each.label || "1";
    if (slash < 0) continue;
    const monitor = result.monitors[name.slice(0, slash)], trace = name.slice(slash + 1);
    if (!monitor) continue;
    for (const d of monitor.decisions) {
      if (d.statistic !== trace) continue;
      for (const level of d.levels) levels.push({ value: level * each.factor, label: d.name, scale });
      if (d.passed !== null && d.passed !== undefined) moments.push({ time: d.passed, label: "decision" });
    }
    for (const f of monitor.findings) {
      if (!f.estimate || f.estimate.unit !== each.unit || !byName.has(`${name}_standard_deviation`)) continue;
      for (const [title, level] of Object.entries(f.estimate.reference)) levels.push({ value: level * each.factor, label: title, scale });
      if (f.since !== null && f.since > 0) moments.push({ time: f.since, label: f.status });
      if (Number.isFinite(f.end)) moments.push({ time: f.end, label: "ended" });
    }
  }
  return { levels, moments };
}

function stretchesOf(panel, data) {
  const slash = panel[0].indexOf("/"), part = slash > 0 && data.get(`${panel[0].slice(0, slash)}/enabled`);
  if (!part) return [];
  const found = [];
  for (let at = 0; at < part.time.length; at++) {
    if (!(part.upper[at] > 0.5)) continue;
    const end = part.time[at + 1] ?? part.time[at], last = found[found.length - 1];
    if (last && last[1] >= part.time[at]) last[1] = end; else found.push([part.time[at], end]);
  }
  return found;
}

function Panel({ at, panel, panels, byName, result, data, overData, shift, view, onView, measured, change }) {
  const outputs = useRef({});
  const curves = useMemo(() => curvesOf(panel, byName, data, overData, shift), [panel.join("\n"), byName, data, overData, shift]);
  const { levels, moments } = useMemo(() => limitsOf(panel, byName, result), [panel.join("\n"), byName, result]);
  const stretches = useMemo(() => stretchesOf(panel, data), [panel.join("\n"), data]);
  const onCursor = (time) => {
    for (const c of curves) {
      const out = outputs.current[c.name];
      if (!out) continue;
      const i = Number.isFinite(time) && c.time.length ? nearest(c.time, time) : -1;
      out.textContent = i < 0 || c.lower[i] === null ? "" : c.lower[i] === c.upper[i] ? figure(c.lower[i]) : `${figure(c.lower[i], 3)} … ${figure(c.upper[i], 3)}`;
    }
  };
  const titles = panel.map((n) => `${byName.get(n).title}${byName.get(n).label ? ` [${byName.get(n).label}]` : ""}`).join(", ");
  const drop = (e) => { e.preventDefault(); const n = e.dataTransfer.getData("text/plain"); if (byName.has(n)) change(added(panels, n, Math.min(at, without(panels, n).length - 1))); };
  const move = (by) => { const next = [...panels]; const [out] = next.splice(at, 1); next.splice(at + by, 0, out); change(next); };
  return stack`<section class="card panel" data-title=${titles} onDragOver=${(e) => e.preventDefault()} onDrop=${drop}>
    <div class="chips">${curves.map((c) => html`<span class="chip" key=${c.name} title=${`${c.name}: ${(byName.get(c.name) || {}).meaning || ""}`}><i style=${{ background: c.colour }}></i>${c.title}${c.label ? ` [${c.label}]` : ""}
        ${c.lower.every((v) => v === null) && html`<span class="small">no value in this stretch</span>`}${byName.has(c.name) && html`<button class="plain" aria-label=${`Remove ${c.title}`} onClick=${() => change(without(panels, c.name))}>×</button>`}<output ref=${(el) => { outputs.current[c.name] = el; }}></output></span>`)}
      <span class="end tools">${at > 0 && html`<button class="plain" aria-label="Panel up" title="Panel up" onClick=${() => move(-1)}>↑</button><button class="plain" title="Overlay on the panel above" aria-label="Overlay on the panel above" onClick=${() => change(panels.flatMap((p, i) => (i === at - 1 ? [[...p, ...panel]] : i === at ? [] : [p])))}>⤒</button>`}
        ${at < panels.length - 1 && html`<button class="plain" aria-label="Panel down" title="Panel down" onClick=${() => move(1)}>↓</button>`}
        ${panel.length > 1 && html`<button class="plain" title="Stack: a panel each" aria-label="Stack: a panel each" onClick=${() => change(panels.flatMap((p, i) => (i === at ? p.map((n) => [n]) : [p])))}>≡</button>`}</span></div>
    ${curves.length ? html`<${TimeChart} curves=${curves} view=${view} levels=${levels} moments=${moments} stretches=${stretches} measured=${measured} onView=${onView} onCursor=${onCursor} onMeasure=${(name, time) => set({ [name]: +time.toPrecision(9) })} label=${`${titles} over time, from ${clock(view[0])} to ${clock(view[1])}`} />` : html`<${Loading} />`}</section>`;
}

function Tools({ address, series, result, over, overResult, wanted, view, span, onView, place }) {
  const parameters = { name: wanted.slice(0, 60), result: result ? result.key : "", start: view[0], stop: view[1] };
  const out = (kind) => `/api/series/${series.key}/export${query({ ...parameters, kind })}`;
  const whole = view[0] <= span[0] && view[1] >= span[1];
  const since = (found) => found && Object.values(found.monitors).map((m) => m.findings[0] && m.findings[0].since).filter((v) => v !== null && v !== undefined)[0];
  const event = Number.isFinite(since(result)) && Number.isFinite(since(overResult)) ? since(result) - since(overResult) : NaN;
  return stack`<div class="row tools card"><span>${clock(view[0], view[1] - view[0])} to ${clock(view[1], view[1] - view[0])} <span class="small">${whole ? "the whole drive" : clock(view[1] - view[0])}${whole ? ", " : " of "}${clock(span[1] - span[0])}</span></span>
    <button onClick=${() => onView(-Infinity, Infinity)} disabled=${whole}>All</button>
    <span class="grow"></span>
    ${address.over ? html`<span class="small">overlaid: ${address.over.split("/").pop()}</span><label><span class="small">shifted by [s]</span><input type="number" step="any" class="shift" value=${address.shift || 0} onChange=${(e) => set({ shift: e.target.value })} size="8" /></label>
      ${Number.isFinite(event) && html`<button onClick=${() => set({ shift: +event.toPrecision(8) })}>Align at the change</button>`}<button onClick=${() => set({ over: "", shift: "" }, true)}>Remove</button>` : html`<button onClick=${() => go("", { pick: 1, ...address, view: undefined })}>Overlay another drive</button>`}
    <span class="group"><span class="small">Export</span><a class="button" href=${out("csv")} download>CSV</a><a class="button" href=${out("parquet")} download>Parquet</a><button onClick=${() => picture(place.current, "tierod.png")}>PNG</button>
    <button onClick=${() => navigator.clipboard && navigator.clipboard.writeText(location.href)} title="Copies the address of exactly this view">Link</button></span></div>`;
}

function Measured({ seriesKey, result, wanted, byName, measured }) {
  const { a, b } = measured, there = Number.isFinite(a) || Number.isFinite(b);
  const key = result ? result.key : "";
  const found = useFetched(async (signal) => {
    if (!there || !wanted.length) return null;
    const at = (time) => (Number.isFinite(time) ? windows(seriesKey, { name: wanted, result: key, start: time, stop: time, points: 10 }, signal) : null);
    const both = Number.isFinite(a) && Number.isFinite(b);
    return { a: await at(a), b: await at(b), between: both && a !== b ? await windows(seriesKey, { name: wanted, result: key, start: Math.min(a, b), stop: Math.max(a, b), points: 2000 }, signal) : null };
  }, [seriesKey, key, wanted.join("\n"), a, b]).data;
  if (!there || !found) return null;
  const value = (part, name, time) => { const w = part && part.get(name); if (!w || !w.time.length) return NaN; const v = w.lower[nearest(w.time, time)]; return v === null ? NaN : v * byName.get(name).factor; };
  const extreme = (name, of, side) => { const w = found.between && found.between.get(name); if (!w) return NaN; const inside = w[side].filter((v, i) => v !== null && w.time[i] >= Math.min(a, b) && w.time[i] <= Math.max(a, b)); return inside.length ? inside.reduce((x, y) => of(x, y)) * byName.get(name).factor : NaN; };
  return stack`<section class="card"><div class="row"><h2 class="grow">Measured</h2><span>A ${clock(a)}, B ${clock(b)}${Number.isFinite(b - a) ? `, B − A ${figure(b - a, 6)} s` : ""}</span><button onClick=${() => set({ a: "", b: "" })}>Clear</button></div>
    <div class="wide" tabindex="0"><table class="dense"><thead><tr><th>signal</th><th class="n">at A</th><th class="n">at B</th><th class="n">B − A</th><th class="n">lowest between</th><th class="n">highest between</th><th>unit</th></tr></thead>
    <tbody>${wanted.map((n) => { const one = value(found.a, n, a), two = value(found.b, n, b); return stack`<tr><td>${byName.get(n).title}</td><td class="n">${figure(one, 6)}</td><td class="n">${figure(two, 6)}</td><td class="n">${figure(two - one, 6)}</td><td class="n">${figure(extreme(n, Math.min, "lower"))}</td><td class="n">${figure(extreme(n, Math.max, "upper"))}</td><td>${byName.get(n).label}</td></tr>`; })}</tbody></table></div></section>`;
}
