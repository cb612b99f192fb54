// A vehicle: trend of every estimate over its drives, parameters with spread and origin.
import { html, stack, useMemo } from "./html.js";
import { get } from "./api.js";
import { go, link, set } from "./address.js";
import { TrendChart } from "./chart.js";
import { Badge, date, figure, Loading, sentence, spread, Table, Trouble, useFetched, Work } from "./parts.js";
import { shownIn } from "./findings.js";
import { Choice, useFleet } from "./fleet.js";

export function Vehicle({ address, site }) {
  if (!site) return stack`<${Loading} />`;
  const results = address.results || site.results[0] || "";
  return stack`<div class="row"><h1 class="grow">Vehicle ${address.car || address.name || ""}</h1>${site.results.length > 0 && html`<${Choice} site=${site} name=${results} /><${CarChoice} results=${results} car=${address.car || ""} />`}</div>
    ${address.car && results && html`<${Car} key=${results + address.car} results=${results} car=${address.car} />`}
    <${Parameters} address=${address} site=${site} />`;
}

function CarChoice({ results, car }) {
  return stack`<form class="row" onSubmit=${(e) => { e.preventDefault(); set({ results, car: e.target.car.value.trim() }, true); }}><label><span class="small">car</span><input name="car" value=${car} placeholder="name in the fleet" required /></label><button>Show</button></form>`;
}

function Car({ results, car }) {
  const fleet = useFleet(results);
  const found = useFetched((signal) => (fleet.data ? get(`/api/fleets/${encodeURIComponent(results)}/car`, { vehicle: car }, signal) : null), [results, car, !!fleet.data]);
  if (fleet.job) return stack`<${Work} job=${fleet.job} />`;
  if (fleet.error || found.error) return stack`<${Trouble} error=${fleet.error || found.error} again=${found.again} />`;
  if (!found.data) return stack`<${Loading} what="Reading the drives" />`;
  const { row, listed, drives } = found.data;
  return stack`<section class="card"><h2>${row.state ? html`<${Badge} status=${row.state} text=${row.summary} /> ` : `${sentence(row.summary || "no remark").slice(0, -1)}: `}${car}</h2>
      ${(listed ? listed.reasons : []).map((r) => html`<p>${sentence(r.text)} ${sentence(`What to do: ${r.inspect}`)}</p>`)}${!listed && row.why && html`<p>${sentence(row.why)}</p>`}
      <dl class="facts"><div><dt>drives</dt><dd>${row.drives}</dd></div><div><dt>last drive</dt><dd>${(row.last || "–").slice(0, 10)}</dd></div>${Object.entries(row.cohort || {}).map(([k, v]) => html`<div><dt>${k}</dt><dd>${v}</dd></div>`)}</dl></section>
    ${found.data.quantities.map((q, at) => html`<${Trend} key=${at} quantity=${q} drives=${drives} band=${found.data.bands[at]} car=${car} />`)}
    <${Drives} drives=${drives} />`;
}

function Trend({ quantity, drives, band, car }) {
  const [factor, unit] = shownIn(quantity.unit);
  const own = useMemo(() => drives.filter((d) => d.monitor === quantity.monitor && (d.judged || "") === (quantity.judged || "") && d.quantity === quantity.quantity && d.estimate !== null && d.start !== null).sort((a, b) => a.start - b.start), [drives, quantity]);
  const chart = useMemo(() => ({
    days: own.map((d) => d.start), values: own.map((d) => factor * d.estimate), errors: own.map((d) => (d.deviation === null ? 0 : 1.96 * factor * d.deviation)),
    band: band && band.day.length ? { days: band.day.map((d) => d * 86400), middle: band.level.map((v) => factor * v), lower: band.level.map((v, i) => factor * (v - 1.96 * band.deviation[i])), upper: band.level.map((v, i) => factor * (v + 1.96 * band.deviation[i])) } : null,
  }), [own, band]);
  if (!own.length) return null;
  const last = own[own.length - 1];
  const levels = [["nominal", last.nominal], ["limit", last.limit]].filter(([, v]) => v !== null && v !== undefined).map(([label, v]) => ({ label, value: factor * v }));
  const moments = band ? [["step", band.stepped], ["alarm", band.alarmed]].filter(([, day]) => Number.isFinite(day)).map(([label, day]) => ({ time: day * 86400, label })) : [];
  const open = (at) => { const d = own[at]; if (d && d.file) go("recording", { file: d.file }); };
  return stack`<section class="card"><h2>${sentence(quantity.quantity).replace(/\.$/, "")} <span class="small">[${unit}], ${quantity.monitor}</span></h2>
    <${TrendChart} ...${chart} levels=${levels} moments=${moments} unit=${unit} label=${`${quantity.quantity} of ${car} over ${own.length} drives`} onPick=${own.some((d) => d.file) ? open : undefined} />
    <p class="small">Points: drives with their 95 % interval. ${band ? "Band: level at 15 °C, estimated from the drives since its last step." : "The smoothed level is worked out for the worst 400 cars."} Dashed: nominal and limit.</p></section>`;
}

function Drives({ drives }) {
  return stack`<details class="card" open><summary>Drives (${drives.length} findings)</summary><${Table} dense caption="Drives" rows=${drives.slice().reverse().slice(0, 300)} columns=${[
    { title: "date", show: (d) => date(d.start) },
    { title: "recording", text: true, show: (d) => (d.file ? html`<a href=${link("recording", { file: d.file })}>${d.recording_name.split("/").pop()}</a>` : (d.recording_name || "–").split("/").pop()) },
    { title: "monitor", show: (d) => `${d.monitor}${d.judged ? `, ${d.judged.replaceAll("_", " ")}` : ""}` },
    { title: "verdict", show: (d) => html`<${Badge} status=${d.status} />` },
    { title: "estimate (95 % interval)", n: true, show: (d) => { if (d.estimate === null) return "–"; const [f, u] = shownIn(d.unit); return `${d.deviation === null ? figure(f * d.estimate, 3) : spread(f * d.estimate, f * d.deviation)} ${u}`; } },
    { title: "cause", text: true, key: "cause" },
  ]} />${drives.some((d) => !d.file) && html`<p class="small">Recordings without a link lie outside of the folders that are served.</p>`}</details>`;
}

function Parameters({ address, site }) {
  const name = address.name || site.vehicle || site.vehicles[0];
  const found = useFetched((signal) => get("/api/vehicle", { name }, signal), [name]);
  const names = [...new Set([...(site.vehicle ? [site.vehicle] : []), ...site.vehicles])];
  return stack`<section class="card"><div class="row"><h2 class="grow">Parameters</h2><label><span class="small">vehicle</span><select onChange=${(e) => set({ name: e.target.value })}>${names.map((n) => html`<option value=${n} selected=${n === name}>${n.split("/").pop()}</option>`)}</select></label></div>
    ${found.error && html`<${Trouble} error=${found.error} />`}
    ${found.data && html`<p>${sentence(found.data.description)} <span class="small">${sentence(found.data.source)}</span></p>${found.data.not_good_for.map((n) => html`<p class="note">Not good for: ${n}</p>`)}
    <${Table} dense blocks caption="Parameters" rows=${found.data.parameters} columns=${[
      { title: "parameter", show: (p) => html`<span title=${p.meaning}>${p.name.replaceAll("_", " ")}</span>` },
      { title: "value", n: true, show: (p) => figure(p.value, 5) }, { title: "± standard deviation", n: true, show: (p) => (p.standard_deviation === null ? html`<span title="not known">?</span>` : figure(p.standard_deviation, 2)) },
      { title: "unit", show: (p) => shownIn("")[1] + p.unit.replaceAll("**2", "²").replaceAll("*", "·") },
      { title: "origin", text: true, show: (p) => html`${p.assumed && html`<span class="badge watch">assumed</span> `}<span class="small">${p.assumed ? p.source.replace(/^assumed:? ?/i, "") : p.source}</span>` },
    ]} /><p class="small">Which of these your drives can identify, and how well: <code>tierod identify vehicle drive.mf4 --vehicle ${found.data.name}</code>.</p>`}</section>`;
}
