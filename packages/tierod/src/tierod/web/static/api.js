// Requests to the server: JSON, packets of numbers, and errors as sentences.

export const SILENT = "The server does not answer: is “tierod serve” still running? Start it again, then reload.";

export class Problem extends Error {
  constructor(message, status) { super(message); this.status = status; }
}

async function answered(path, options = {}) {
  let answer;
  try {
    answer = await fetch(path, { credentials: "same-origin", ...options });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Problem(SILENT, 0);
  }
  if (answer.ok) return answer;
  let sentence = `the server answered with status ${answer.status}`;
  try { sentence = (await answer.json()).error || sentence; } catch (_) { /* no JSON */ }
  throw new Problem(sentence, answer.status);
}

export function query(parameters) {
  const made = new URLSearchParams();
  for (const [name, value] of Object.entries(parameters || {})) {
    if (Array.isArray(value)) value.forEach((each) => made.append(name, each));
    else if (value !== undefined && value !== null && value !== "") made.set(name, value);
  }
  const text = made.toString();
  return text ? `?${text}` : "";
}

export const get = async (path, parameters, signal) => (await answered(path + query(parameters), { signal })).json();

let kept;
/** What is served; it stays as it is while the server runs. */
export const site = () => {
  kept = kept || get("/api/site").catch((error) => { kept = undefined; throw error; });
  return kept;
};

export const post = async (path, content) => (await answered(path, {
  method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(content),
})).json();

export const cancel = async (job) => (await answered(`/api/jobs/${job}`, { method: "DELETE" })).json();

export const upload = async (file) => (await answered(`/api/uploads${query({ name: file.name })}`, {
  method: "POST", headers: { "content-type": "application/octet-stream" }, body: file,
})).json();

/** Stretches of signals: Map of name -> {time, lower, upper, exact}; values are numbers, null where missing. */
export async function windows(key, parameters, signal) {
  const buffer = await (await answered(`/api/series/${key}/window${query(parameters)}`, { signal })).arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const found = new Map();
  let place = 4 + length;
  const floats = (count) => {
    const values = new Float32Array(buffer, place, count);
    place += 4 * count;
    return values;
  };
  for (const each of head) {
    const time = new Float64Array(buffer, place, each.count);
    place += 8 * each.count;
    const lower = floats(each.count);
    const upper = each.exact ? lower : floats(each.count);
    place += (8 - (place % 8)) % 8;
    found.set(each.name, parted(time, lower, upper, each.exact));
  }
  return found;
}

/** As plain arrays, with a null in every pause, so that no line is drawn over it. */
function parted(time, lower, upper, exact) {
  const steps = [];
  for (let at = 1; at < time.length; at += Math.max(1, time.length >> 7)) steps.push(time[at] - time[at - 1]);
  steps.sort((one, other) => one - other);
  const longest = 10 * (steps[steps.length >> 1] || Infinity) + 0.5;
  const times = [], low = [], high = [];
  const plain = (value) => (value === value ? value : null);
  for (let at = 0; at < time.length; at++) {
    if (at && time[at] - time[at - 1] > longest) { times.push((time[at] + time[at - 1]) / 2); low.push(null); high.push(null); }
    times.push(time[at]); low.push(plain(lower[at])); high.push(plain(upper[at]));
  }
  return { time: times, lower: low, upper: high, exact };
}
