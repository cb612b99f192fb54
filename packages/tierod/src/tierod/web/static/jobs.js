// Work that waits, runs and is done; and the interface for programs.
import { html, stack, useEffect, useState } from "./html.js";
import { cancel, get } from "./api.js";
import { Badge, date, Loading, sentence, Table, Trouble, useFetched } from "./parts.js";

export function JobList() {
  const [state, put] = useState({});
  useEffect(() => {
    let timer, over = false;
    const look = async () => {
      try { const jobs = await get("/api/jobs"); if (!over) put({ jobs }); } catch (error) { if (!over) put((before) => ({ ...before, error })); }
      if (!over) timer = setTimeout(look, 1000);
    };
    look();
    return () => { over = true; clearTimeout(timer); };
  }, []);
  return stack`<h1>Work</h1>${state.error && !state.jobs && html`<${Trouble} error=${state.error} />`}${!state.jobs ? html`<${Loading} />` : state.jobs.length ? html`<div class="card"><${Table} caption="Work" rows=${state.jobs.map((j) => ({ ...j, key: j.id }))} columns=${[
    { title: "what", text: true, key: "about" }, { title: "state", show: (j) => html`<${Badge} status=${j.state} />` },
    { title: "done", show: (j) => html`<progress max="1" value=${j.share} aria-label=${`${j.about}: done`}></progress>` },
    { title: "", text: true, show: (j) => sentence(j.text) }, { title: "since", n: true, show: (j) => date(j.created) },
    { title: "", show: (j) => (j.state === "running" || j.state === "waiting" ? html`<button onClick=${() => cancel(j.id)}>Cancel</button>` : "") },
  ]} /></div>` : html`<p class="card">There are no jobs yet: open a recording from the <a href="/">list</a>.</p>`}`;
}

export function Interface() {
  const found = useFetched(() => get("/api/openapi.json"), []);
  if (found.error) return stack`<${Trouble} error=${found.error} />`;
  if (!found.data) return stack`<${Loading} />`;
  const rows = Object.entries(found.data.paths).flatMap(([path, methods]) => Object.entries(methods).map(([method, each]) => ({ key: method + path, path, method: method.toUpperCase(), what: each.description || each.summary, takes: (each.parameters || []).map((p) => p.name).join(", ") })));
  return stack`<h1>Interface for programs</h1><p>OpenAPI ${found.data.openapi}: <a href="/api/openapi.json" target="_blank">openapi.json</a>. Examples: <a href="/api/site" target="_blank">/api/site</a>.</p><div class="card"><${Table} blocks caption="Endpoints" rows=${rows} columns=${[{ title: "method", key: "method" }, { title: "address", show: (r) => html`<code>${r.path}</code>` }, { title: "what", text: true, key: "what" }, { title: "takes", text: true, key: "takes" }]} /></div>`;
}
