// The searchable tree of signals: click or Enter adds a panel, with shift into the last one; or drag into a panel.
import { html, useMemo, useState } from "./html.js";

export function Tree({ signals, shown, onToggle }) {
  const [search, put] = useState("");
  const groups = useMemo(() => {
    const there = new Set(signals.map((each) => each.name)), part = (name) => name.endsWith("_standard_deviation") && there.has(name.slice(0, -19)); // drawn as a band
    const wanted = search.trim().toLowerCase().split(/\s+/).filter(Boolean), found = new Map();
    for (const each of signals) {
      if (!wanted.length && part(each.name) && !shown.has(each.name)) continue;
      const text = `${each.name} ${each.title} ${each.meaning} ${each.source} ${each.group}`.toLowerCase();
      if (!wanted.every((word) => text.includes(word))) continue;
      if (!found.has(each.group)) found.set(each.group, []);
      found.get(each.group).push(each);
    }
    return [...found];
  }, [signals, search, shown.size]);
  return html`<div class="tree">
    <label class="row"><span class="small">Signals</span><input type="search" class="grow" placeholder="search" value=${search} onInput=${(e) => put(e.target.value)} aria-label="Search signals" /></label>
    <p class="small">Click adds a panel; Shift-click overlays on the last panel; or drag.</p>
    ${groups.length ? groups.map(([group, list], at) => html`<details key=${group} open=${!!search || at < 2 || group.startsWith("Estimates")}><summary>${group} (${list.length})</summary>
      <ul>${list.slice(0, 300).map((each) => html`<li key=${each.name}><button class="signal" draggable="true" aria-pressed=${shown.has(each.name)}
        title=${`${each.name}${each.meaning ? `: ${each.meaning}` : ""}${each.positive ? ` Positive: ${each.positive}.` : ""}${each.source ? ` From ${each.source}.` : ""}${(each.note || "").startsWith("derived:") ? ` ${each.note[0].toUpperCase()}${each.note.slice(1)}.` : ""} ${each.count} samples.`}
        onDragStart=${(e) => e.dataTransfer.setData("text/plain", each.name)}
        onClick=${(e) => onToggle(each.name, e.shiftKey)}><span>${each.title}${(each.note || "").startsWith("derived:") && html` <small>derived</small>`}</span><span class="unit">${each.label}</span></button></li>`)}</ul>
      ${list.length > 300 && html`<p class="small">${list.length - 300} more: search for them.</p>`}</details>`)
      : html`<p class="small">${search ? `No signal has “${search}” in its name or meaning.` : "No signals yet."}</p>`}
  </div>`;
}
