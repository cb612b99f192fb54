// A scenario: car, course, fault, size; run; truth beside the estimate.
import { html, stack, useEffect, useMemo, useState } from "./html.js";
import { get, post, windows } from "./api.js";
import { link } from "./address.js";
import { sentence, Loading, Trouble, useFetched, useJob, Work } from "./parts.js";
import { clipped } from "./recording.js";
import { TimeAxis, Verdict } from "./findings.js";
import { colour, TimeChart } from "./chart.js";

export function Scenario() {
  const all = useFetched(() => get("/api/scenarios"), []);
  const [chosen, put] = useState({ scenario: "", car: "midsize-eps", course: "mixed", seconds: 300, seed: 1, fault: "friction-step", size: "", start: 120 });
  const [job, begin] = useState(null);
  const followed = useJob(job);
  if (all.error) return stack`<${Trouble} error=${all.error} again=${all.again} />`;
  if (!all.data) return stack`<${Loading} />`;
  const { cars, courses, faults } = all.data;
  const now = { ...chosen, car: known(cars, chosen.car), course: known(courses, chosen.course) };
  const fault = faults.find((f) => f.name === now.fault);
  const change = (more) => put({ ...chosen, ...more });
  const run = () => post("/api/scenarios", { car: now.car, course: now.course, seconds: +now.seconds || null, seed: Math.trunc(+now.seed) || 0, faults: fault ? [{ name: fault.name, size: now.size, start: now.start === "" ? null : +now.start }] : [] }).then(begin, (error) => begin({ id: "", state: "failed", text: error.message }));
  const option = (list, value) => list.map((each) => html`<option value=${each.name} selected=${each.name === value} title=${each.description}>${each.name}</option>`);
  const words = (list, name) => (list.find((each) => each.name === name) || {}).description || "";
  return stack`<h1>Scenario</h1><form class="card" onSubmit=${(e) => { e.preventDefault(); run(); }}><p>Drive a virtual car with a fault of your choice, and see the truth beside what the monitors estimate.</p>
    <div class="row"><label>car <select onChange=${(e) => change({ car: e.target.value })}>${option(cars, now.car)}</select></label><label>course <select onChange=${(e) => change({ course: e.target.value })}>${option(courses, now.course)}</select></label>
    <label>duration [s] <input type="number" min="1" max="3600" step="any" value=${now.seconds} onInput=${(e) => change({ seconds: e.target.value })} /></label><label>seed <input type="number" min="0" step="1" value=${now.seed} onInput=${(e) => change({ seed: e.target.value })} /></label></div>
    <div class="row"><label>fault <select onChange=${(e) => change({ fault: e.target.value, size: "" })}><option value="">none</option>${option(faults, now.fault)}</select></label>
    ${fault && html`${fault.size && html`<label>size <input value=${now.size} placeholder=${fault.size} onInput=${(e) => change({ size: e.target.value })} /></label>`}<label>begins at [s] <input type="number" min="0" step="any" value=${now.start} onInput=${(e) => change({ start: e.target.value })} /></label>`}
    <button class="main" disabled=${followed && (followed.state === "running" || followed.state === "waiting")}>Run</button></div>
    <p class="small">${sentence(words(cars, now.car))} ${sentence(words(courses, now.course))} ${fault ? sentence(fault.description) : ""}</p></form>
    <${Work} job=${followed} again=${run} />
    ${followed && followed.state === "done" && html`<${Outcome} found=${followed.found} />`}`;
}

const known = (list, name) => (list.some((each) => each.name === name) ? name : list[0].name);

function Outcome({ found }) {
  const series = useFetched(() => get(`/api/series/${found.series}`), [found.series]).data;
  const result = useFetched(() => (found.result ? get(`/api/results/${found.result}`) : null), [found.result]).data;
  const [range, put] = useState([NaN, NaN]);
  if (!series || (found.result && !result)) return stack`<${Loading} />`;
  const view = clipped(range[0], range[1], series.span), file = `uploads/scenarios/${found.path.split("/").pop()}`;
  const onView = (a, b) => put(clipped(a, b, series.span));
  const windows = found.windows.map((w) => ({ time: w.start, label: w.name || w.element }));
  return stack`${found.diverged_at !== null && html`<p class="note">The run diverged at ${found.diverged_at} s: the fault is larger than the car survives.</p>`}
    ${found.why && html`<p class="note">No verdict: ${found.why}.</p>`}
    <p class="row"><a class="button main" href=${link("recording", { file })}>Open as a recording</a> <span class="small">${found.faults.map(sentence).join(" ")}</span></p>
    ${result && html`<${TimeAxis} result=${result} span=${series.span} view=${view} onView=${onView} />`}
    <${Beside} series=${series} result=${result} view=${view} onView=${onView} moments=${windows} />
    ${result && html`<div class="cards">${Object.entries(result.monitors).map(([m, each]) => html`<${Verdict} key=${m} monitor=${m} each=${each} result=${result} />`)}</div>`}
    <details class="card"><summary>The scenario as a file</summary><pre>${found.scenario}</pre></details>`;
}

/** Pairs of (estimate, truth) by their names: friction/friction_torque and truth_friction_torque. */
function pairs(signals, estimates) {
  const truths = new Map(signals.filter((s) => s.name.startsWith("truth_")).map((s) => [s.name.slice(6), s]));
  const deviations = new Set(estimates.map((s) => s.name));
  const found = [];
  for (const each of estimates) {
    const own = each.name.split("/")[1];
    const truth = truths.get(own) || truths.get(own.replace(/^estimated_/, "")) || (own.includes("friction") && !own.includes("standard") && each.label === "N·m" ? truths.get("friction_level") || truths.get("friction") : null);
    if (truth && truth.unit === each.unit) found.push({ estimate: each, truth, spread: deviations.has(`${each.name}_standard_deviation`) });
  }
  return found.sort((a, b) => b.spread - a.spread).slice(0, 8);
}

/** Truth beside estimate: every estimate of a monitor with the true signal of the simulation in one panel. */
function Beside({ series, result, view, onView, moments }) {
  const list = useMemo(() => (result ? pairs(series.signals, result.signals) : []), [series, result]);
  const [state, put] = useState({});
  useEffect(() => {
    if (!list.length) return undefined;
    const stop = new AbortController();
    const name = [...new Set(list.flatMap((p) => [p.estimate.name, p.truth.name, ...(p.spread ? [`${p.estimate.name}_standard_deviation`] : [])]))];
    windows(series.key, { name, result: result.key, start: view[0], stop: view[1], points: 1600 }, stop.signal).then((found) => put({ found }), (error) => error.name === "AbortError" || put({ error }));
    return () => stop.abort();
  }, [list, view[0], view[1]]);
  if (state.error) return stack`<${Trouble} error=${state.error} />`;
  if (!list.length) return stack`<p class="card small">No estimate of the monitors that ran has a true signal of the same name in this car; open it as a recording to see all truth_ signals.</p>`;
  if (!state.found) return null;
  return list.map((p) => html`<${One} key=${p.estimate.name} pair=${p} found=${state.found} view=${view} onView=${onView} moments=${moments} />`);
}

function One({ pair, found, view, onView, moments }) {
  const curves = useMemo(() => {
    const scale = (values) => values.map((v) => (v === null ? null : v * pair.estimate.factor));
    const e = found.get(pair.estimate.name), t = found.get(pair.truth.name), d = found.get(`${pair.estimate.name}_standard_deviation`);
    const lower = scale(e.lower), upper = e.exact ? lower : scale(e.upper), low = scale(t.lower), half = d && d.time.length === e.time.length ? scale(d.upper).map((v) => (v === null ? null : 1.96 * v)) : null;
    const band = half && { lower: lower.map((v, i) => (v === null || half[i] === null ? null : v - half[i])), upper: upper.map((v, i) => (v === null || half[i] === null ? null : v + half[i])) };
    return [{ name: pair.estimate.name, title: "estimate", label: pair.estimate.label, colour: colour(0), time: e.time, lower, upper, band },
      { name: pair.truth.name, title: "truth", label: pair.estimate.label, colour: colour(1), dashed: true, time: t.time, lower: low, upper: t.exact ? low : scale(t.upper) }];
  }, [pair, found]);
  return stack`<section class="card panel" data-title=${pair.estimate.title}><div class="chips"><b>${pair.estimate.title} [${pair.estimate.label}]</b> <span class="small">${pair.estimate.name.split("/")[0]}</span>
    ${curves.map((c) => html`<span class="chip"><i style=${{ background: c.colour }}></i>${c.title}</span>`)}</div>
    <${TimeChart} curves=${curves} view=${view} moments=${moments} onView=${onView} height=${210} label=${`${pair.estimate.title}: estimate beside truth`} /></section>`;
}
