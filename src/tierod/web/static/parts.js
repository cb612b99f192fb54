// Small parts that views share: figures, badges, problems, jobs, tables.
import { html, useEffect, useLayoutEffect, useState } from "./html.js";
import { cancel, get, Problem } from "./api.js";

export function figure(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value !== 0 && (Math.abs(value) < 1e-4 || Math.abs(value) >= 1e7)) return value.toExponential(digits - 1).replace("-", "−");
  return String(+value.toPrecision(digits)).replace("-", "−");
}

export function clock(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const sign = seconds < 0 ? "−" : "", whole = Math.abs(seconds);
  if (whole < 120) return `${sign}${figure(whole, 4)} s`;
  const h = Math.floor(whole / 3600), m = Math.floor(whole / 60) % 60, s = Math.floor(whole % 60);
  return `${sign}${h ? `${h}:` : ""}${String(m).padStart(h ? 2 : 1, "0")}:${String(s).padStart(2, "0")}`;
}

export function size(bytes) {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let at = 0;
  while (bytes >= 1000 && at < units.length - 1) { bytes /= 1000; at++; }
  return `${figure(bytes, 3)} ${units[at]}`;
}

export const date = (seconds) => (seconds ? new Date(seconds * 1000).toISOString().slice(0, 16).replace("T", " ") : "–");

const KINDS = { healthy: ["good", "✓"], consistent: ["good", "✓"], rising: ["watch", "▲"], suspect: ["watch", "▲"], inconsistent: ["watch", "▲"], fault: ["bad", "✕"], failed: ["bad", "✕"], done: ["good", "✓"], "can run": ["good", "✓"],
  judged: ["good", "✓"], "limit soon": ["bad", "▲"], changed: ["watch", "▲"], "probably changed": ["watch", "▲"], "near the limit": ["watch", "▲"], running: ["open", "…"], waiting: ["open", "…"] };
export const kind = (status) => (KINDS[status] || ["open", "?"])[0];
export const Badge = ({ status }) => html`<span class=${`badge ${kind(status)}`}><span aria-hidden="true">${(KINDS[status] || ["", "?"])[1]} </span>${status}</span>`;

export const Trouble = ({ error, again }) => html`<div class="problem" role="alert"><p>${sentence(error.message || String(error))}</p>${again && html`<button onClick=${again}>Try again</button>`}</div>`;
export const Loading = ({ what }) => html`<p class="loading" role="status">${what || "Loading"} …</p>`;
export const sentence = (text) => { const plain = String(text || "").trim(); const name = /^[^ ]*(_|\.\w)/.test(plain); return plain ? (name ? plain[0] : plain[0].toUpperCase()) + plain.slice(1) + (/[.!?…]$/.test(plain) ? "" : ".") : ""; };

/** {data, error, loading, again} of something that is fetched when one of the keys changes. */
export function useFetched(load, keys) {
  const [state, put] = useState({ loading: true });
  const [turn, next] = useState(0);
  useLayoutEffect(() => {
    const stop = new AbortController();
    put((before) => (before.loading && !before.error ? before : { ...before, loading: true, error: undefined }));
    Promise.resolve(load(stop.signal)).then(
      (data) => stop.signal.aborted || put({ data, loading: false }),
      (error) => stop.signal.aborted || error.name === "AbortError" || put({ error, loading: false }),
    );
    return () => stop.abort();
  }, [...keys.map((key) => (Number.isNaN(key) ? "" : key)), turn]); // NaN differs from itself
  return { ...state, again: () => next(turn + 1) };
}

/** A job that is followed until it ends. */
export function useJob(first) {
  const [job, put] = useState(first);
  const id = first && first.id;
  useEffect(() => {
    put(first);
    if (!id) return undefined;
    let timer, over = false, lost = 0;
    const look = async () => {
      try {
        const now = await get(`/api/jobs/${id}`);
        lost = 0;
        if (over) return;
        put(now);
        if (now.state === "waiting" || now.state === "running") timer = setTimeout(look, 350);
      } catch (error) {
        if (over) return;
        if (error instanceof Problem && error.status === 0 && lost++ < 20) timer = setTimeout(look, 1500);
        else put((before) => ({ ...before, state: "failed", text: error.message }));
      }
    };
    if (!first.state || first.state === "waiting" || first.state === "running") timer = setTimeout(look, 150);
    return () => { over = true; clearTimeout(timer); };
  }, [id]);
  return job && job.id === id ? job : first;
}

export function Work({ job, again }) {
  if (!job || job.state === "done") return null;
  if (job.state === "failed" || job.state === "cancelled") return html`<${Trouble} error=${{ message: job.text }} again=${again} />`;
  return html`<div class="card" role="status"><div class="row"><span class="grow">${sentence(job.about)} ${job.state === "waiting" ? "It waits for others." : job.text ? `${sentence(job.text)}` : ""}</span>
    <button onClick=${() => cancel(job.id)}>Cancel</button></div>
    <progress max="1" value=${job.share} aria-label=${job.about}></progress></div>`;
}

/** A table that scrolls inside its frame; columns: {key, title, n, show(row), sort}. */
export function Table({ columns, rows, caption, sort, onSort, dense }) {
  const up = sort && !sort.startsWith("-"), by = (sort || "").replace("-", "");
  return html`<div class="wide" tabindex="0" role="region" aria-label=${caption}><table class=${dense ? "dense" : ""}>
    <thead><tr>${columns.map((c) => html`<th scope="col" class=${c.n ? "n" : ""} aria-sort=${by === c.sort && c.sort ? (up ? "ascending" : "descending") : undefined}>
      ${c.sort && onSort ? html`<button onClick=${() => onSort(by === c.sort && up ? `-${c.sort}` : c.sort)}>${c.title}${by === c.sort ? (up ? " ▲" : " ▼") : ""}</button>` : c.title}</th>`)}</tr></thead>
    <tbody>${rows.map((row, at) => html`<tr key=${row.key || at}>${columns.map((c) => html`<td class=${c.n ? "n" : c.text ? "text" : ""}>${c.show ? c.show(row) : row[c.key]}</td>`)}</tr>`)}</tbody>
  </table></div>`;
}
