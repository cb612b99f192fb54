// A new recording: upload or path, channel map proposed and corrected in a table, what can run, run.
import { html, stack, useEffect, useState } from "./html.js";
import { get, post, upload } from "./api.js";
import { link, set } from "./address.js";
import { Badge, Loading, sentence, size, Table, Trouble, useFetched, useJob, Work } from "./parts.js";

export function New({ address, site }) {
  if (!site) return stack`<${Loading} />`;
  return stack`<h1>New recording</h1>${address.file ? html`<${Mapping} key=${address.file} address=${address} site=${site} />` : html`<${Choose} site=${site} />`}`;
}

function Choose({ site }) {
  const [state, put] = useState({});
  const [over, hover] = useState(false);
  const take = async (file) => {
    if (!file) return;
    if (file.size > site.upload_limit) { put({ error: { message: `${file.name} has ${size(file.size)}; ${size(site.upload_limit)} are taken at most. Put it into a folder that is served.` } }); return; }
    put({ busy: file.name });
    try { const done = await upload(file); set({ file: done.file }, true); } catch (error) { put({ error }); }
  };
  return stack`<div class=${`card drop ${over ? "over" : ""}`} onDragOver=${(e) => { e.preventDefault(); hover(true); }} onDragLeave=${() => hover(false)} onDrop=${(e) => { e.preventDefault(); hover(false); take(e.dataTransfer.files[0]); }}>
      <p><label class="button">Upload a recording <input type="file" onChange=${(e) => take(e.target.files[0])} /></label></p><p class="small">or drop it here: MF4, Parquet, CSV, CAN log, MATLAB, rosbag … up to ${size(site.upload_limit)}. It stays on the machine of the server.</p>
      ${state.busy && html`<${Loading} what=${`Uploading ${state.busy}`} />`}${state.error && html`<${Trouble} error=${state.error} />`}</div>
    <div class="card"><form class="row" onSubmit=${(e) => { e.preventDefault(); set({ file: e.target.path.value.trim() }, true); }}><label class="grow">Path <input name="path" class="grow" required placeholder=${`${site.roots[0] || "folder"}/drive.mf4`} list="roots" /></label><datalist id="roots">${site.roots.map((r) => html`<option value=${`${r}/`}></option>`)}</datalist><button class="main">Look into it</button></form>
    <p class="small">Within the folders that are served: ${site.roots.join(", ") || "none"}. Or open it from the <a href="/">list</a>.</p></div>`;
}

function Mapping({ address, site }) {
  const file = address.file;
  const [proposal, begin] = useState(null);
  const [entries, edit] = useState(null);
  const [inspection, look] = useState(null);
  const [run, start] = useState(null);
  const proposed = useJob(proposal), inspected = useJob(inspection), running = useJob(run);
  const vehicle = address.vehicle || "", dbc = address.dbc ? [address.dbc] : [];
  const failed = (put) => (error) => put({ id: "", state: "failed", text: error.message });
  const propose = () => post("/api/proposals", { file, dbc }).then(begin, failed(begin));
  useEffect(() => { edit(null); look(null); start(null); propose(); }, [file, address.dbc]);
  useEffect(() => { if (proposed && proposed.state === "done" && !entries) edit(proposed.found.entries.map((e) => ({ ...e, use: !e.source.startsWith("truth_") }))); }, [proposed && proposed.state]);
  const map = entries && toMap(entries, address.time);
  const asked = { file, vehicle, dbc, channel_map: map && (map.time || Object.keys(map.signals).length) ? map : null };
  const check = () => post("/api/inspections", asked).then(look, failed(look));
  const analyse = () => post("/api/analyses", asked).then(start, failed(start));
  return stack`<p>${file} <a href="/new">another one</a></p>
    <div class="card row"><label>judged as <select value=${vehicle} onChange=${(e) => set({ vehicle: e.target.value })}><option value="">${site.vehicle ? site.vehicle.split("/").pop() : "as the recording names it"}</option>${site.vehicles.map((each) => html`<option value=${each} selected=${vehicle === each}>${each}</option>`)}</select></label>
      <${Databases} address=${address} served=${site.dbc} />
      <label>time unit <select onChange=${(e) => set({ time: e.target.value })}>${["", "s", "ms", "us", "ns"].map((each) => html`<option value=${each} selected=${(address.time || "") === each}>${each || "as the file says"}</option>`)}</select></label>
      <button onClick=${check} disabled=${!entries}>What can run?</button><button class="main" onClick=${analyse} disabled=${running && (running.state === "running" || running.state === "waiting")}>Run</button>
      ${map && html`<a class="button" href=${`data:application/toml;charset=utf-8,${encodeURIComponent(toText(entries, file, address.time))}`} download="car.channels.toml">Save the map</a>`}</div>
    <${Work} job=${proposed} again=${propose} />
    ${proposed && proposed.state === "failed" && !entries && html`<p>Without a proposal, signals are assigned by the names in the file; “Run” judges with these. <button onClick=${() => edit([])}>Write the map by hand</button></p>`}
    <${Work} job=${inspected} again=${check} /><${Work} job=${running} again=${analyse} />
    ${running && running.state === "done" && html`<p class="card">Done: <a class="button main" href=${link("recording", { file, vehicle })}>Open the recording</a></p>`}
    ${inspected && inspected.state === "done" && html`<${Inspected} found=${inspected.found} />`}
    ${entries && html`<${MapTable} entries=${entries} unmatched=${(proposed && proposed.found.unmatched) || []} sure=${proposed && proposed.state === "done"} signals=${site.signals} edit=${edit} />`}`;
}

/** The CAN database of a bus log: one of the folders that are served, or a new one. */
function Databases({ address, served }) {
  const found = useFetched(() => get("/api/files", { search: ".dbc", count: 200 }).then((list) => list.entries.map((each) => each.file).filter((each) => each.toLowerCase().endsWith(".dbc"))), [address.dbc]);
  const [state, put] = useState({});
  const take = async (file) => { if (!file) return; try { put({}); set({ dbc: (await upload(file)).file }, true); } catch (error) { put({ error }); } };
  const names = [...new Set([...(address.dbc ? [address.dbc] : []), ...(found.data || [])])];
  return html`<label>CAN database <select class="file" onChange=${(e) => set({ dbc: e.target.value }, true)}><option value="">${served.length ? served.join(", ") : "none"}</option>${names.map((each) => html`<option value=${each} selected=${each === address.dbc}>${each}</option>`)}</select></label>
    <label class="button">Upload a database<input class="away" type="file" accept=".dbc" onChange=${(e) => take(e.target.files[0])} /></label>${state.error && html`<${Trouble} error=${state.error} />`}`;
}

const toMap = (entries, unit) => ({ ...(unit ? { time: { unit } } : {}), signals: Object.fromEntries(entries.filter((e) => e.use && e.signal && e.source).map((e) => [e.signal, { source: e.source, ...(e.unit ? { unit: e.unit } : {}), sign: +e.sign, factor: +e.factor || 1, optional: true }])) });
const quoted = (text) => JSON.stringify(text);
const toText = (entries, file, unit) => [`title = ${quoted(`from ${file.split("/").pop()}`)}`, ...(unit ? [`\n[time]\nunit = ${quoted(unit)}`] : []), ...Object.entries(toMap(entries).signals).map(([name, e]) => `\n[signals.${name}]\nsource = ${quoted(e.source)}\n${e.unit ? `unit = ${quoted(e.unit)}\n` : ""}sign = ${e.sign}\nfactor = ${e.factor}\noptional = true`)].join("\n") + "\n";

function MapTable({ entries, unmatched, sure, signals, edit }) {
  const change = (at, more) => edit(entries.map((e, i) => (i === at ? { ...e, ...more } : e)));
  const columns = [...new Set([...entries.map((e) => e.source), ...entries.flatMap((e) => e.others), ...unmatched.map((u) => u.name)])].sort();
  const names = Object.keys(signals), wide = (of) => Math.min(Math.max(...entries.map((e) => (e[of] || "").length), 8) + 2, 44);
  return stack`<section class="card"><h2>Channel map</h2><p class="small">${sure ? "As proposed from names and values; correct what is wrong. Doubtful ones are marked." : "Name a signal, and the column of the file that holds it."}</p>
    <datalist id="columns">${columns.slice(0, 2000).map((c) => html`<option value=${c}></option>`)}</datalist><datalist id="signals">${names.map((n) => html`<option value=${n}></option>`)}</datalist>
    <${Table} caption="Channel map" dense blocks rows=${entries.map((e, at) => ({ ...e, at, key: at }))} columns=${[
      { title: "use", show: (e) => html`<input type="checkbox" checked=${e.use} aria-label=${`use ${e.signal}`} onChange=${(ev) => change(e.at, { use: ev.target.checked })} />` },
      { title: "signal", show: (e) => html`<input list="signals" size=${wide("signal")} value=${e.signal} aria-label="signal" title=${(signals[e.signal] || {}).meaning || ""} onChange=${(ev) => change(e.at, { signal: ev.target.value })} />` },
      { title: "column in the file", show: (e) => html`<input list="columns" size=${wide("source")} value=${e.source} aria-label=${`column of ${e.signal}`} onChange=${(ev) => change(e.at, { source: ev.target.value })} />` },
      { title: "unit", show: (e) => html`<input size="8" value=${e.unit} aria-label=${`unit of ${e.signal}`} onChange=${(ev) => change(e.at, { unit: ev.target.value })} />` },
      { title: "sign", show: (e) => html`<select value=${String(e.sign)} aria-label=${`sign of ${e.signal}`} onChange=${(ev) => change(e.at, { sign: +ev.target.value })}><option value="1">+1</option><option value="-1" selected=${e.sign < 0}>−1</option></select>` },
      { title: "factor", show: (e) => html`<input size="6" value=${e.factor} aria-label=${`factor of ${e.signal}`} onChange=${(ev) => change(e.at, { factor: ev.target.value })} />` },
      { title: "why", text: true, show: (e) => html`${e.doubtful && html`<span class="badge watch">check</span>`} <span class="small">${(e.reasons || []).filter(Boolean).join("; ")}</span>` },
    ]} />
    <p class="row"><button onClick=${() => edit([...entries, { signal: "", source: "", unit: "", factor: 1, sign: 1, use: true, others: [], reasons: [] }])}>Add a signal</button><span class="small">${unmatched.length === 0 ? sure ? "Every column is matched." : "" : `Not matched: ${unmatched.slice(0, 20).map((u) => u.name).join(", ")}${unmatched.length > 20 ? `, and ${unmatched.length - 20} more` : ""}`}</span></p></section>`;
}

function Inspected({ found }) {
  return stack`<section class="card"><h2>What can run</h2>${found.warnings.map((w) => html`<p class="note">${sentence(w)}</p>`)}
    <ul>${found.monitors.map((m) => html`<li><${Badge} status=${m.can_run ? "can run" : "not available"} /> <b>${m.name}</b>${m.condition && m.can_run ? ` if ${m.condition}` : ""}${m.obstacles.length ? html`: <span class="small">${sentence(m.obstacles[0])}</span>` : ""}</li>`)}</ul>
    <details><summary>${found.channels.length} channels</summary><${Table} dense caption="Channels" rows=${found.channels.slice(0, 400)} columns=${[{ title: "channel", key: "name" }, { title: "in the file", key: "source" }, { title: "unit", key: "unit" }, { title: "samples", n: true, key: "samples" }, { title: "rate [Hz]", n: true, show: (c) => c.rate && +c.rate.toPrecision(4) }, { title: "remarks", text: true, show: (c) => c.remarks.join("; ") }]} /></details></section>`;
}
