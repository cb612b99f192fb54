// Findings: in words, and on the time axis; remarks of the reader, said once above charts and verdicts.
import { html, stack } from "./html.js";
import { link } from "./address.js";
import { Badge, clock, figure, interval, kind, sentence } from "./parts.js";

const NEAR = 0.02;

/** Lanes of the time axis: one per monitor, one per sensor or actuator with an episode. */
export function lanes(result, span) {
  const found = [];
  for (const [monitor, each] of Object.entries(result.monitors)) {
    const first = each.findings[0];
    if (first) {
      const status = first.status, marks = [], decided = [];
      const end = first.end ?? null;
      if (first.since !== null) marks.push({ from: first.since, to: end ?? span[1], text: end === null ? `${status} since ${clock(first.since)}` : `${status} from ${clock(first.since)} to ${clock(end)}`, kind: kind(status) });
      else marks.push({ from: span[0], to: span[1], text: status, kind: kind(status) });
      for (const decision of each.decisions) if (decision.passed !== null && decision.passed !== undefined) decided.push({ from: decision.passed, to: decision.passed + NEAR * (span[1] - span[0]), text: "◆", point: true, kind: "watch", title: `${decision.name}: ${decision.rule}; passed at ${clock(decision.passed)}` });
      if (!decided.length && Number.isFinite(first.declared)) decided.push({ from: first.declared, to: first.declared + NEAR * (span[1] - span[0]), text: "◆", point: true, kind: "watch", title: `declared at ${clock(first.declared)}` });
      found.push({ name: monitor, monitor, marks });
      if (decided.length) found.push({ name: `${monitor}: decisions`, monitor, marks: decided });
    }
    for (const element of each.elements) {
      if (!element.episodes.length) continue;
      found.push({ name: `${monitor}: ${element.name.replaceAll("_", " ")}`, monitor, marks: element.episodes.map((one) => ({ from: one.start, to: one.end ?? span[1], text: one.kind || one.candidates.join(" or ") || element.status, kind: kind(element.status) })) });
    }
  }
  return found;
}

export function TimeAxis({ result, span, view, onView }) {
  const width = view[1] - view[0];
  const at = (time) => `${(100 * (Math.min(Math.max(time, view[0]), view[1]) - view[0])) / width}%`;
  const all = lanes(result, span);
  return stack`<section class="card times" aria-label="Findings on the time axis"><h2>Findings over time</h2>
    <div class="lane"><span class="small">shown</span><div class="track" title="The stretch that the charts show">
      <i style=${{ left: `${(100 * (view[0] - span[0])) / (span[1] - span[0])}%`, width: `${Math.max((100 * width) / (span[1] - span[0]), 0.3)}%` }}></i></div></div>
    ${all.map((lane) => html`<div class="lane" key=${lane.name}><span>${lane.name}</span><div class="track">
      ${lane.marks.filter((m) => m.to >= view[0] && m.from <= view[1]).map((m) => html`<button key=${m.text + m.from} class=${m.kind} style=${{ left: at(m.from), width: m.point ? "16px" : `calc(${at(m.to)} - ${at(m.from)})`, minWidth: "6px", zIndex: m.point ? 1 : 0 }}
        title=${`${m.title || m.text} (click to look at it)`} aria-label=${`${lane.name}: ${m.title || m.text}`} onClick=${() => around(m, span, onView)}>${m.text}</button>`)}
    </div></div>`)}
    ${!all.length && html`<p class="small">No monitor could judge this recording.</p>`}</section>`;
}

function around(mark, span, onView) {
  const near = 0.04 * (span[1] - span[0]);
  if (mark.from <= span[0]) onView(-Infinity, Infinity); else onView(mark.from - near, Math.min(mark.from + near, span[1]));
}

const shownUnits = { rad: [180 / Math.PI, "°"], "rad/s": [180 / Math.PI, "°/s"], "m/s": [3.6, "km/h"] };
export const shownIn = (unit) => shownUnits[unit] || [1, (unit || "").replaceAll("**2", "²").replaceAll("**3", "³").replaceAll("*", "·")];

function Estimated({ estimate }) {
  const [factor, unit] = shownIn(estimate.unit);
  const [value, low, high] = interval(factor * estimate.value, factor * estimate.standard_deviation, estimate.quantity.endsWith(", rms") ? 0 : -Infinity);
  const levels = Object.entries(estimate.reference).map(([name, level]) => `; ${name} ${figure(factor * level)}`).join("");
  return html`<p><span class="value">${value} ${unit}</span><span class="small"> 95 %: ${low} to ${high}. ${sentence(estimate.quantity).replace(/\.$/, "")}${levels}</span></p>`;
}

export function Verdict({ monitor, each, result, above = new Set() }) {
  return stack`<article class="card"><h2>${monitor} <span class="small">${each.variant}</span></h2>
    ${each.findings.map((f) => html`<div class=${`finding ${kind(f.status)}`}>
      <p><${Badge} status=${f.status} /> ${sentence(f.headline)}</p>
      ${f.estimate && html`<${Estimated} estimate=${f.estimate} />`}
      ${[...f.details, ...(f.cause ? [f.cause] : [])].map((d) => html`<p class="small">${sentence(d)}</p>`)}
      ${f.action && f.action !== "none" && html`<p>${sentence(f.action)}</p>`}
      ${f.warnings.filter((w) => !above.has(w) && !f.headline.includes(w)).map((w) => html`<p class="note">${sentence(w)}</p>`)}</div>`)}
    ${each.elements.some((e) => e.status !== "healthy") && html`<details><summary>${each.elements.length} sensors and actuators</summary><ul>${each.elements.map((e) => html`<li>${e.name.replaceAll("_", " ")}: <${Badge} status=${e.status} />${e.cause ? ` (${e.cause})` : ""}</li>`)}</ul></details>`}
    <p><a class="button" href=${`/recording?report=${result.key}/${monitor}`}>Report</a></p></article>`;
}

const UNIT = /^(\w+) \(.*\) has no unit in the file and was taken as ([^\s:,]+)(?:, but reaches \S+ and looks like ([^\s:]+))?:/;

/** {units: [{name, taken, like}], others} of the warnings: those on units name one signal each, and become one sentence. */
export function sorted(warnings) {
  const units = [], others = [];
  for (const each of warnings) {
    const found = UNIT.exec(each);
    if (found) units.push({ name: found[1].replaceAll("_", " "), taken: found[2].replaceAll("**2", "²").replaceAll("*", "·"), like: found[3] });
    else others.push(each);
  }
  return { units, others };
}

/** Warnings that several verdicts share, each with the monitors that it holds for; those of the reading are not among them. */
export function shared(monitors, warnings) {
  const found = new Map(), known = new Set(warnings);
  for (const [name, each] of Object.entries(monitors)) for (const f of each.findings) for (const w of f.warnings) if (!known.has(w)) found.set(w, (found.get(w) || new Set()).add(name));
  return new Map([...found].filter(([, names]) => names.size > 1));
}

export function Remarks({ warnings, file }) {
  if (!warnings.length) return null;
  const { units, others } = sorted(warnings), doubtful = units.filter((each) => each.like), rest = units.filter((each) => !each.like);
  return html`<div class="note">
    ${doubtful.length > 0 && html`<p><b>Probably in other units:</b> ${doubtful.map((each) => `${each.name} was taken as ${each.taken} and looks like ${each.like}`).join("; ")}. Charts and verdicts are wrong until that is corrected.</p>`}
    ${rest.length > 0 && html`<p>No unit in the file: ${rest.map((each) => `${each.name} was taken as ${each.taken}`).join(", ")}.</p>`}
    ${others.map((each) => html`<p>${sentence(each)}</p>`)}
    ${units.length > 0 && html`<p><a href=${link("new", { file })}>${doubtful.length ? "Correct the units" : "Confirm the units"}</a> in the channel map.</p>`}</div>`;
}
