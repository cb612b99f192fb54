// Identification: drives and a vehicle file become a vehicle file with what the drives identify.
import { html, stack, useEffect, useRef, useState } from "./html.js";
import { get, post } from "./api.js";
import { link, set } from "./address.js";
import { figure, Loading, sentence, Table, Trouble, useFetched, useJob, Work } from "./parts.js";
import { shownIn } from "./findings.js";

const SUBJECTS = [["vehicle", "a vehicle, from ordinary drives"], ["column", "a column, from a bench or a drive"], ["motor", "a motor"], ["inverter", "an inverter"], ["thresholds", "limits of the condition monitor"]];
export const parsed = (text) => (text || "").split(";").filter(Boolean);

export function Identify({ address, site }) {
  const [job, begin] = useState(null);
  const followed = useJob(job);
  if (!site) return stack`<${Loading} />`;
  const files = parsed(address.files), subject = SUBJECTS.some(([name]) => name === address.subject) ? address.subject : "vehicle";
  const vehicle = address.name || site.vehicle || site.vehicles[0];
  const names = [...new Set([...(address.name ? [address.name] : []), ...(site.vehicle ? [site.vehicle] : []), ...site.vehicles])];
  const change = (next) => set({ files: next.join(";"), found: "" });
  const run = () => post("/api/identifications", { subject, files, vehicle }).then(begin, (error) => begin({ id: "", state: "failed", text: error.message }));
  const done = followed && followed.state === "done" && followed.found.identified;
  useEffect(() => { if (done) set({ found: done, served: followed.found.vehicle_file ? `uploads/identified/${followed.found.vehicle_file.split("/").pop()}` : "" }); }, [done]);
  const busy = followed && (followed.state === "running" || followed.state === "waiting");
  return stack`<h1>Identify parameters</h1>
    <form class="card" onSubmit=${(e) => { e.preventDefault(); run(); }}><p>From a vehicle file and some drives, identify the parameters of the vehicle: values, standard deviations, and what to drive for those that are not identifiable.</p>
      <div class="row"><label>what <select onChange=${(e) => set({ subject: e.target.value, found: "" })}>${SUBJECTS.map(([name, words]) => html`<option value=${name} selected=${name === subject}>${words}</option>`)}</select></label>
        <label>known before <select onChange=${(e) => set({ name: e.target.value, found: "" })}>${names.map((n) => html`<option value=${n} selected=${n === vehicle}>${n.split("/").pop()}</option>`)}</select></label></div>
      ${files.map((file) => html`<div class="row" key=${file}><a class="grow" href=${link("recording", { file })}>${file}</a><button type="button" class="plain" aria-label=${`Leave out ${file}`} onClick=${() => change(files.filter((each) => each !== file))}>×</button></div>`)}
      <${Add} files=${files} change=${change} />
      <div class="row"><button class="main" disabled=${!files.length || busy}>Identify</button>${!files.length && html`<span class="small">Add one drive or more.</span>`}</div></form>
    <${Work} job=${followed} again=${run} />
    ${address.found && html`<${Found} key=${address.found} found=${address.found} served=${address.served} files=${files} />`}`;
}

/** Recordings of the folders that are served, by a part of their names. */
function Add({ files, change }) {
  const [search, put] = useState(""), timer = useRef(0);
  const found = useFetched((signal) => (search ? get("/api/files", { search, count: 12 }, signal) : null), [search]);
  const list = search && found.data ? found.data.entries.filter((e) => !e.folder && !files.includes(e.file)) : [];
  return stack`<label>add a drive <input type="search" placeholder="part of its name" onInput=${(e) => { clearTimeout(timer.current); const v = e.target.value.trim(); timer.current = setTimeout(() => put(v), 200); }} onKeyDown=${(e) => { if (e.key === "Enter") e.preventDefault(); }} /></label>
    ${found.error && html`<${Trouble} error=${found.error} />`}
    ${list.length > 0 && html`<div class="row">${list.map((e) => html`<button type="button" key=${e.file} onClick=${() => change([...files, e.file])}>+ ${e.file}</button>`)}</div>`}
    ${search && found.data && !list.length && html`<p class="small">No further file has “${search}” in its name.</p>`}`;
}

function Found({ found, served, files }) {
  const state = useFetched((signal) => get(`/api/identifications/${found}`, {}, signal), [found]);
  if (state.error) return stack`<${Trouble} error=${state.error} again=${state.again} />`;
  if (!state.data) return stack`<${Loading} />`;
  const d = state.data, page = `/api/identifications/${found}/page`, kept = (d.judged || []).filter((each) => each.why && !d.parameters.some((p) => p.name === each.name));
  const value = (p, v, s) => (v === null || v === undefined ? "–" : `${figure(shownIn(p.unit)[0] * v)}${s ? ` ± ${figure(shownIn(p.unit)[0] * s, 2)}` : ""}`);
  return stack`<section class="card"><h2>${sentence(d.subject).slice(0, -1)} of ${d.vehicle}, from ${d.files.join(", ")}</h2>
      ${d.doubt && html`<p class="note">No vehicle file is written: ${sentence(d.doubt)}</p>`}
      ${!d.parameters.length && html`<p>The recordings identify no parameter.</p>`}
      ${d.parameters.length > 0 && html`<${Table} dense caption="Parameters found" rows=${d.parameters} columns=${[
        { title: "parameter", show: (p) => p.name.replaceAll("_", " ") },
        { title: "before ± standard deviation", n: true, show: (p) => value(p, p.before, p.before_standard_deviation) },
        { title: "found ± standard deviation", n: true, show: (p) => value(p, p.value, p.standard_deviation) },
        { title: "95 % interval", n: true, show: (p) => `${value(p, p.interval[0])} to ${value(p, p.interval[1])}` },
        { title: "unit", show: (p) => shownIn(p.unit)[1] },
      ]} />`}
      ${kept.length > 0 && html`<h3>Kept as before</h3><ul>${kept.map((each) => html`<li><b>${each.name.replaceAll("_", " ")}</b>: ${sentence(each.why)}</li>`)}</ul>`}
      ${d.remarks.map((each) => html`<p class="small">${sentence(each)}</p>`)}
      <p class="row tools">${d.written && html`<a class="button main" href=${`/api/identifications/${found}/vehicle`} download=${`${d.vehicle}-identified.toml`}>Download the vehicle file</a>`}
        ${served && files[0] && html`<a class="button" href=${link("recording", { file: files[0], vehicle: served })}>Judge ${files[0].split("/").pop()} by it</a><a class="button" href=${link("vehicle", { name: served })}>Its parameters</a>`}
        <a class="button" href=${page} target="_blank" rel="noopener">The page in a window of its own</a></p></section>
    <iframe class="report" src=${page} title="Page of the identification" sandbox="allow-scripts allow-downloads allow-popups"></iframe>`;
}
