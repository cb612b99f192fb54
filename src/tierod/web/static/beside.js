// Truth beside estimate: every estimate of a monitor with the true signal of the simulation in one panel.
import { html, stack, useEffect, useMemo, useState } from "./html.js";
import { windows } from "./api.js";
import { colour, TimeChart } from "./chart.js";
import { Trouble } from "./parts.js";

/** Pairs of (estimate, truth) by their names: friction/friction_torque and truth_friction_torque. */
export function pairs(signals, estimates) {
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

export function Beside({ series, result, view, onView, moments }) {
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
