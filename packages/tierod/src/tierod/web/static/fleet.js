// A fleet: worst first, filter, cohorts, ledger, and the way down to cars and recordings.
import { html, stack, useEffect, useRef, useState } from "./html.js";
import { get } from "./api.js";
import { link, set } from "./address.js";
import { Badge, figure, kind, Loading, sentence, spread, Table, Trouble, useFetched, useJob, Work } from "./parts.js";
import { shownIn } from "./findings.js";

const COUNT = 50;

/** What is known of a fleet; a job works it out first where it is new. */
export function useFleet(name) {
  const [turn, again] = useState(0);
  const found = useFetched((signal) => (name ? get(`/api/fleets/${encodeURIComponent(name)}`, {}, signal) : null), [name, turn]);
  const job = useJob(found.data && found.data.job);
  useEffect(() => { if (job && job.state === "done") again((before) => before + 1); }, [job && job.state]);
  return { ...found, job: found.data && found.data.job ? job : null, data: found.data && !found.data.job ? found.data : null };
}

export function Choice({ site, name }) {
  return stack`<label><span class="small">results</span><select onChange=${(e) => set({ results: e.target.value, at: "", cohort: "", state: "" }, true)}>${site.results.map((each) => html`<option value=${each} selected=${each === name}>${each}</option>`)}</select></label>`;
}

export const Empty = () => html`<p class="card">No results of a fleet are served. Judge one with <code>tierod fleet 'drives/**/*.mf4' --vehicles fleet.toml -o results/</code>, then <code>tierod serve recordings/ results/</code>.</p>`;

export function Fleet({ address, site }) {
  const name = address.results || (site && site.results[0]) || "";
  const fleet = useFleet(name);
  if (!site) return stack`<${Loading} />`;
  if (!site.results.length) return stack`<h1>Fleet</h1><${Empty} />`;
  return stack`<div class="row"><h1 class="grow">Fleet</h1><${Choice} site=${site} name=${name} /></div>
    ${fleet.error && html`<${Trouble} error=${fleet.error} again=${fleet.again} />`}<${Work} job=${fleet.job} again=${fleet.again} />
    ${fleet.data && html`<${Ledger} fleet=${fleet.data} /><${Cars} address=${address} name=${name} fleet=${fleet.data} /><${Cohorts} fleet=${fleet.data} />`}`;
}

function Ledger({ fleet }) {
  const all = Object.entries(fleet.recordings), total = all.reduce((sum, [, count]) => sum + count, 0) || 1;
  const look = { judged: "good", skipped: "watch", failed: "bad" };
  return stack`<section class="card"><h2><span class=${`badge ${fleet.colour}`}><span aria-hidden="true">${fleet.symbol} </span>${fleet.status}</span> ${fleet.title}</h2><p class="small">${fleet.vehicles} ${fleet.vehicles === 1 ? "car" : "cars"}, ${total} ${total === 1 ? "recording" : "recordings"}</p>
    <div class="map" role="img" aria-label=${`Recordings: ${all.map(([o, c]) => `${c} ${o}`).join(", ")}`}>${all.map(([outcome, count]) => html`<span class=${look[outcome] || "open"} title=${`${count} ${outcome}`} style=${{ width: `${(100 * count) / total}%` }}>${count} ${outcome}</span>`)}</div>
    ${fleet.not_judged.length > 0 && html`<details><summary>Why recordings were not judged (${fleet.not_judged.length} reasons)</summary><${Table} dense caption="Recordings that were not judged" rows=${fleet.not_judged} columns=${[{ title: "outcome", show: (r) => html`<span class=${`badge ${look[r.outcome] || "open"}`}>${r.outcome}</span>` }, { title: "recordings", n: true, key: "count" }, { title: "reason", text: true, show: (r) => sentence(r.reason) }, { title: "such as", text: true, show: (r) => r.examples.join(", ") }]} /></details>`}
    ${fleet.remarks.map((r) => html`<p class="note">${sentence(r)}</p>`)}</section>`;
}

function Cars({ address, name, fleet }) {
  const { search = "", state = "", cohort = "", sort = "rank" } = address, from = +(address.at || 0);
  const timer = useRef(0);
  const found = useFetched((signal) => get(`/api/fleets/${encodeURIComponent(name)}/cars`, { search, state, cohort, sort, offset: from, count: COUNT }, signal), [name, search, state, cohort, sort, from]);
  const first = fleet.quantities[0], [factor, unit] = shownIn(first ? first.unit : "");
  const kinds = first ? first.cohorts.map((c) => `${c.kind}=${c.name}`) : [];
  return stack`<section class="card"><div class="row"><h2 class="grow">Worst first</h2>
      <label><span class="small">search</span><input type="search" value=${search} onInput=${(e) => { clearTimeout(timer.current); const v = e.target.value; timer.current = setTimeout(() => set({ search: v, at: "" }), 120); }} /></label>
      <label><span class="small">state</span><select onChange=${(e) => set({ state: e.target.value, at: "" })}>${["", "any", "fault", "to confirm", "limit soon", "changed", "probably changed", "near the limit"].map((s) => html`<option value=${s} selected=${s === state}>${s === "" ? "all cars" : s === "any" ? "any to look at" : s}</option>`)}</select></label>
      <label><span class="small">cohort</span><select onChange=${(e) => set({ cohort: e.target.value, at: "" })}><option value="">all</option>${kinds.map((k) => html`<option value=${k} selected=${k === cohort}>${k.replace("=", " ")}</option>`)}</select></label></div>
    ${found.error && html`<${Trouble} error=${found.error} again=${found.again} />`}
    ${found.data && html`<${Table} caption="Cars" sort=${sort} onSort=${(s) => set({ sort: s, at: "" })} rows=${found.data.rows.map((r) => ({ ...r, key: r.vehicle }))} columns=${[
      { title: "rank", n: true, key: "rank", sort: "rank" },
      { title: "vehicle", sort: "vehicle", show: (r) => html`<a href=${link("vehicle", { results: name, car: r.vehicle })}>${r.vehicle}</a>` },
      { title: "state", sort: "state", show: (r) => (r.state ? html`<${Badge} status=${r.state} text=${r.summary} />` : html`<span class="small">${r.summary || "no remark"}</span>`) },
      { title: "why", text: true, key: "why" },
      { title: `level (95 % interval) [${unit}]`, n: true, sort: "level", show: (r) => (r.level === undefined || r.level === null ? "–" : html`<span title=${r.step ? `since ${r.step.since}, ${figure(factor * r.step.before, 3)} ${unit} before` : ""}>${spread(factor * r.level, factor * r.deviation)}</span>`) },
      { title: "limit in 90 d", n: true, sort: "chance", show: (r) => (r.chance === undefined || r.chance === null ? "–" : r.chance < 1e-3 ? "< 0.1 %" : `${figure(100 * r.chance, 2)} %`) },
      { title: "drives", n: true, key: "drives", sort: "drives" },
      { title: "last", n: true, sort: "last", show: (r) => (r.last || "–").slice(0, 10) },
      { title: "cohort", show: (r) => Object.entries(r.cohort || {}).map(([k, v]) => `${k} ${v}`).join(", ") },
    ]} />
    <div class="row small"><span>${found.data.total} cars</span>${from > 0 && html`<button onClick=${() => set({ at: Math.max(from - COUNT, 0) || "" })}>Before</button>`}${from + COUNT < found.data.total && html`<button onClick=${() => set({ at: from + COUNT })}>Further</button>`}</div>`}</section>`;
}

function Cohorts({ fleet }) {
  return fleet.quantities.filter((q) => q.cohorts.length).map((q) => {
    const [factor, unit] = shownIn(q.unit), widest = Math.max(...q.cohorts.map((c) => Math.abs(c.effect) + 1.96 * c.deviation), 1e-12);
    const at = (value) => `${50 + (48 * value) / widest}%`;
    return stack`<section class="card times"><h2>Cohorts: ${q.quantity}</h2><p class="small">Effect against the rest of the fleet with its 95 % interval, the likeliest first; cars differ by ${figure(factor * q.between_cars, 2)} ${unit} from each other.</p>
      ${q.cohorts.slice(0, 15).map((c) => { const low = c.effect - 1.96 * c.deviation, high = c.effect + 1.96 * c.deviation, sure = c.log_odds > 0; return stack`<div class="lane" key=${c.kind + c.name}><span>${c.kind} ${c.name} <span class="small">(${c.cars})</span></span><div class="track" title=${`${spread(factor * c.effect, factor * c.deviation)} ${unit}; ${sure ? "probably differs" : "probably does not differ"}`}>
        <i style=${{ left: at(low), width: `calc(${at(high)} - ${at(low)})` }}></i><i style=${{ left: "50%", width: "1px", background: "var(--muted)" }}></i><span class=${`mark ${sure ? "bad" : "open"}`} style=${{ position: "absolute", left: at(c.effect), width: "3px", height: "20px", background: "var(--kind)" }}></span></div></div>`; })}</section>`;
  });
}
