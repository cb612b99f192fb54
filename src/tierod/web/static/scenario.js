// A scenario: car, course, fault, size; run; truth beside the estimate.
import { html, stack, useState } from "./html.js";
import { get, post } from "./api.js";
import { link } from "./address.js";
import { sentence, Loading, Trouble, useFetched, useJob, Work } from "./parts.js";
import { clipped } from "./recording.js";
import { TimeAxis, Verdict } from "./findings.js";
import { Beside } from "./beside.js";

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
