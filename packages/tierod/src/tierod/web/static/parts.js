// Small parts that views share: figures, badges, problems, jobs, tables.
import { html, useEffect, useLayoutEffect, useState } from "./html.js";
import { cancel, get, Problem } from "./api.js";
import { STATUSES } from "./statuses.js";

export function figure(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value !== 0 && (Math.abs(value) < 1e-4 || Math.abs(value) >= 1e7)) return value.toExponential(digits - 1).replace("-", "−");
  return String(+value.toPrecision(digits)).replace("-", "−");
}

/** [value, lower end, upper end] of the 95 % interval, rounded by its own width; a figure with ± is one standard deviation. */
export function interval(value, deviation, least = -Infinity) {
  const half = 1.96 * deviation;
  const decimals = Number.isFinite(half) && half > 0 ? Math.min(Math.max(1 - Math.floor(Math.log10(half)), 0), 4) : 2;
  return [value, Math.max(value - half, least), value + half].map((v) => (Number.isFinite(v) ? v.toFixed(decimals).replace(/^-(0(\.0*)?)$/, "$1").replace("-", "−") : "–"));
}

export const spread = (value, deviation) => { const [middle, low, high] = interval(value, deviation); return `${middle} (${low} to ${high})`; };

/** A moment, as finely as a stretch of `width` seconds needs it. */
export function clock(seconds, width = NaN) {
  if (!Number.isFinite(seconds)) return "–";
  const fine = width > 0 ? Math.min(Math.max(2 - Math.floor(Math.log10(1.000001 * width)), 0), 6) : NaN, sign = seconds < 0 ? "−" : "", whole = Math.abs(seconds);
  if (whole < 120) return `${+whole.toFixed(fine || 0) === 0 && fine === 0 ? "" : sign}${Number.isFinite(fine) ? whole.toFixed(fine) : figure(whole, 4)} s`;
  const digits = fine > 1 ? fine : 0, total = Math.floor(whole * 10 ** digits) / 10 ** digits;
  const h = Math.floor(total / 3600), m = Math.floor(total / 60) % 60, s = (total % 60).toFixed(digits);
  return `${sign}${h ? `${h}:` : ""}${String(m).padStart(h ? 2 : 1, "0")}:${s.padStart(digits ? 3 + digits : 2, "0")}`;
}

export function size(bytes) {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let at = 0;
  while (bytes >= 1000 && at < units.length - 1) { bytes /= 1000; at++; }
  return `${figure(bytes, 3)} ${units[at]}`;
}

export const date = (seconds) => (seconds ? new Date(seconds * 1000).toISOString().slice(0, 16).replace("T", " ") : "–");

const STATES = { failed: ["bad", "✕"], done: ["good", "✓"], "can run": ["good", "✓"], judged: ["good", "✓"], running: ["open", "…"], waiting: ["open", "…"] };
/** [colour, symbol] of the status of a verdict or a car, from the server; else of the state of a job. */
const looks = (status) => STATUSES[status] || STATES[status] || ["open", "?"];
export const kind = (status) => looks(status)[0];
export const Badge = ({ status, text }) => html`<span class=${`badge ${kind(status)}`}><span aria-hidden="true">${looks(status)[1]} </span>${text || status}</span>`;

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

/** A table that scrolls inside its frame; columns: {key, title, n, show(row), sort}; a narrow page shows each row of `blocks` as a block. */
export function Table({ columns, rows, caption, sort, onSort, dense, blocks }) {
  const up = sort && !sort.startsWith("-"), by = (sort || "").replace("-", "");
  return html`<div class="wide" tabindex="0" role="region" aria-label=${caption}><table class=${`${dense ? "dense" : ""} ${blocks ? "blocks" : ""}`}>
    <thead><tr>${columns.map((c) => html`<th scope="col" class=${c.n ? "n" : ""} aria-sort=${by === c.sort && c.sort ? (up ? "ascending" : "descending") : undefined}>
      ${c.sort && onSort ? html`<button onClick=${() => onSort(by === c.sort && up ? `-${c.sort}` : c.sort)}>${c.title}${by === c.sort ? (up ? " ▲" : " ▼") : ""}</button>` : c.title}</th>`)}</tr></thead>
    <tbody>${rows.map((row, at) => html`<tr key=${row.key || at}>${columns.map((c) => html`<td class=${c.n ? "n" : c.text ? "text" : ""} data-title=${blocks ? c.title : undefined}>${blocks ? html`<div>${c.show ? c.show(row) : row[c.key]}</div>` : c.show ? c.show(row) : row[c.key]}</td>`)}</tr>`)}</tbody>
  </table></div>`;
}
