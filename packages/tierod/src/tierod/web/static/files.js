// The list of recordings: folders by name alone, search, what is analysed already.
import { html, stack, useEffect, useRef, useState } from "./html.js";
import { get } from "./api.js";
import { go, link, set } from "./address.js";
import { date, Loading, size, Table, Trouble, useFetched, Work } from "./parts.js";

const COUNT = 200;

export function Files({ address, site }) {
  const folder = address.folder || "", search = address.search || "", sort = address.sort || "name", from = +(address.at || 0);
  const found = useFetched((signal) => get("/api/files", { folder, search, sort, offset: from, count: COUNT }, signal), [folder, search, sort, from]);
  const list = found.data;
  const open = (entry) => (address.pick ? go("recording", { ...address, view: undefined, pick: undefined, folder: undefined, search: undefined, sort: undefined, at: undefined, over: entry.file }) : go("recording", { file: entry.file }));
  const parts = folder.split("/").filter(Boolean);
  return stack`<h1>${address.pick ? `Choose the drive to overlay on ${(address.file || "").split("/").pop()}` : "Recordings"}</h1>
    ${site && site.demo !== undefined && site.demo !== "" && !address.pick && html`<${Demo} site=${site} again=${found.again} />`}
    <div class="card"><div class="row"><nav class="grow" aria-label="Folder"><a href="/">all folders</a>${parts.map((part, at) => html` / <a href=${link("", { ...address, view: undefined, folder: parts.slice(0, at + 1).join("/"), at: "" })}>${part}</a>`)}</nav>
      <${Search} value=${search} /><label><span class="small">sort</span><select value=${sort} onChange=${(e) => set({ sort: e.target.value, at: "" })}><option value="name">name</option><option value="modified" selected=${sort === "modified"}>newest</option><option value="bytes" selected=${sort === "bytes"}>largest</option></select></label>
      <a class="button" href="/new">New recording</a></div>
    ${found.error && html`<${Trouble} error=${found.error} again=${found.again} />`}
    ${!list && found.loading && html`<${Loading} what="Listing" />`}
    ${list && list.gone.map((name) => html`<p class="note" key=${name}>The folder “${name}” is gone, or cannot be reached: bring it back under its name, or start “tierod serve” with the folder where it is now. <button onClick=${found.again}>Look again</button></p>`)}
    ${list && html`<${Table} caption="Recordings" rows=${list.entries.map((e) => ({ ...e, key: e.file }))} columns=${[
      { title: "name", text: true, show: (e) => (e.folder ? html`<a href=${link("", { ...address, view: undefined, folder: e.file, search: "", at: "" })}>${e.name}/</a>` : html`<a href=${link("recording", { file: e.file })} onClick=${(ev) => { if (!ev.ctrlKey && !ev.metaKey) { ev.preventDefault(); ev.stopPropagation(); open(e); } }}>${e.name}</a>${search ? html` <span class="small">${e.file}</span>` : ""}`) },
      { title: "", show: (e) => (e.analysed ? html`<span class="badge good">analysed</span>` : "") },
      { title: "size", n: true, show: (e) => (e.folder ? "" : size(e.bytes)) },
      { title: "changed", n: true, show: (e) => (e.modified ? date(e.modified) : "") },
    ]} />
    ${!list.entries.length && html`<p>${search ? `No file has “${search}” in its name.` : "This folder is empty: put recordings into it, or upload one under New recording."}</p>`}
    <div class="row small"><span>${list.total} entries${list.complete ? "" : "; the search ended early, name more of the file"}</span>${from > 0 && html`<button onClick=${() => set({ at: Math.max(from - COUNT, 0) || "" })}>Before</button>`}${from + COUNT < list.total && html`<button onClick=${() => set({ at: from + COUNT })}>Further</button>`}</div>`}</div>`;
}

function Search({ value }) {
  const timer = useRef(0);
  const put = (text) => { clearTimeout(timer.current); timer.current = setTimeout(() => set({ search: text, at: "" }), 200); };
  return stack`<label><span class="small">search</span><input type="search" value=${value} onInput=${(e) => put(e.target.value)} aria-label="Search recordings by name" /></label>`;
}

function Demo({ site, again }) {
  const [job, put] = useState(null);
  useEffect(() => {
    let timer;
    const look = async () => {
      try {
        const jobs = await get("/api/jobs");
        const own = jobs.find((each) => each.kind === "demo");
        put(own);
        if (own && (own.state === "running" || own.state === "waiting")) timer = setTimeout(look, 500); else again();
      } catch (_) { timer = setTimeout(look, 2000); }
    };
    look();
    return () => clearTimeout(timer);
  }, []);
  if (job && job.state !== "done") return stack`<${Work} job=${job} />`;
  return stack`<div class="card"><p>This is the demo: a drive of 13 minutes whose friction rises half-way${site.scenarios ? ", and a virtual fleet of 120 cars over a year" : ""}. Your own: <code>tierod serve recordings/ results/ --vehicle car.toml</code></p>
    <p class="row"><a class="button" href=${link("recording", { file: site.demo })}>Open the demo drive</a>${site.scenarios && html`<a class="button" href="/fleet">Look at the fleet</a><a class="button" href="/scenario">Try a scenario</a>`}</p></div>`;
}
