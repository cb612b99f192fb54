// The live bus: the same charts, growing, with verdicts, ages and load; pause and look back.
import { html, stack, useEffect, useMemo, useRef, useState } from "./html.js";
import { set } from "./address.js";
import { colour, TimeChart } from "./chart.js";
import { Badge, clock, figure, kind, Loading, sentence } from "./parts.js";
import { parse, write } from "./panels.js";
import { Tree } from "./tree.js";

const DEGREES = 180 / Math.PI;
const UNITS = { rad: [DEGREES, "°"], "rad/s": [DEGREES, "°/s"], "m/s": [3.6, "km/h"] };
const KEPT = 60000; // samples a signal: ten minutes at 100 Hz; older ones are thinned to one in four

/** Samples of one signal in bounded memory. */
export class Buffer {
  constructor(name, unit) { this.name = name; this.unit = unit; this.time = []; this.values = []; }

  add(times, values) {
    for (let at = 0; at < times.length; at++) { this.time.push(times[at]); this.values.push(values[at]); }
    if (this.time.length > KEPT) this.thin();
  }

  /** The older half keeps lowest and highest of every eight samples; what is older than that goes in the end. */
  thin() {
    const half = this.time.length >> 1, time = [], values = [];
    for (let at = 0; at < half; at += 8) {
      let low = at, high = at;
      for (let k = at; k < Math.min(at + 8, half); k++) { if (this.values[k] < this.values[low]) low = k; if (this.values[k] > this.values[high]) high = k; }
      for (const k of low <= high ? [low, high] : [high, low]) { time.push(this.time[k]); values.push(this.values[k]); }
    }
    this.time = time.concat(this.time.slice(half));
    this.values = values.concat(this.values.slice(half));
  }

  over(from, to, points) {
    let a = this.find(from), b = this.find(to);
    a = Math.max(a - 1, 0); b = Math.min(b + 1, this.time.length);
    const step = Math.max(1, Math.floor((b - a) / points)), time = [], lower = [], upper = [];
    if (step === 1) { const every = this.values.slice(a, b); return { time: this.time.slice(a, b), lower: every, upper: every }; }
    for (let at = a; at < b; at += step) {
      let low = null, high = null;
      for (let k = at; k < Math.min(at + step, b); k++) { const v = this.values[k]; if (v === null) continue; if (low === null || v < low) low = v; if (high === null || v > high) high = v; }
      time.push(this.time[at]); lower.push(low); upper.push(high);
    }
    return { time, lower, upper };
  }

  find(at) { let low = 0, high = this.time.length; while (low < high) { const mid = (low + high) >> 1; if (this.time[mid] < at) low = mid + 1; else high = mid; } return low; }
}

function useBus(on) {
  const held = useRef({ buffers: new Map(), state: null, events: [], latest: 0, delay: NaN });
  const [status, put] = useState("connecting");
  useEffect(() => {
    if (!on) return undefined;
    let socket, timer, over = false;
    const connect = () => {
      socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/live`);
      socket.onopen = () => { held.current.buffers = new Map(); put("connected"); };
      socket.onmessage = (event) => take(held.current, JSON.parse(event.data));
      socket.onclose = () => { if (!over) { put("the connection is lost; trying again"); timer = setTimeout(connect, 2000); } };
    };
    connect();
    return () => { over = true; clearTimeout(timer); socket.close(); };
  }, [on]);
  return [held.current, status];
}

function take(held, message) {
  if (message.event === "samples") {
    for (const [name, each] of Object.entries(message.signals)) {
      let buffer = held.buffers.get(name);
      if (!buffer) { buffer = new Buffer(name, each.unit); held.buffers.set(name, buffer); }
      buffer.add(each.time, each.values);
      const last = each.time[each.time.length - 1];
      if (last > held.latest) held.latest = last;
    }
    if (message.sent) held.delay = Date.now() / 1000 - message.sent;
  } else if (message.event === "state") {
    held.state = message;
    for (const each of message.monitors) for (const [name, value] of Object.entries(each.values)) {
      const full = `${each.monitor}/${name}`;
      let buffer = held.buffers.get(full);
      if (!buffer) { buffer = new Buffer(full, each.units[name] || ""); held.buffers.set(full, buffer); }
      buffer.add([message.time], [value]);
    }
  } else {
    if (message.event === "begin") { held.buffers = new Map(); held.latest = 0; }
    held.events = [message, ...held.events].slice(0, 200);
  }
}

export function Live({ address, site }) {
  const on = !!(site && site.live.length);
  const [bus, status] = useBus(on);
  const [tick, next] = useState(0);
  const [held, hold] = useState(null);
  useEffect(() => { const timer = setInterval(() => { if (!document.hidden) next((before) => before + 1); }, 100); return () => clearInterval(timer); }, []);
  if (!site) return stack`<${Loading} />`;
  if (!on) return stack`<h1>Live</h1><p class="card">No bus is followed. Begin with <code>tierod serve --live socketcan:can0 --dbc car.dbc --vehicle car.toml</code>; without hardware, <code>tierod replay drive.mf4 --interface udp_multicast --channel 239.74.163.2</code> plays a recording and <code>--live udp_multicast:239.74.163.2</code> follows it.</p>`;
  const width = +(address.width || 30), latest = Math.max(bus.latest, width);
  const view = held || [latest - width, latest];
  return stack`<div class="row"><h1 class="grow">Live <span class="small">${site.live.join(", ")}</span></h1>
      <button aria-pressed=${!!held} onClick=${() => hold(held ? null : view)}>${held ? "Go on" : "Pause"}</button>
      <label><span class="small">shown</span><select onChange=${(e) => set({ width: e.target.value })}>${[10, 30, 60, 300, 600].map((s) => html`<option value=${s} selected=${s === width}>${s} s</option>`)}</select></label></div>
    <p class="small" role="status">${status === "connected" ? "" : sentence(status)}</p>
    <${State} bus=${bus} />
    <${LivePanels} address=${address} bus=${bus} view=${view} tick=${held ? 0 : tick} onView=${(a, b) => hold(Number.isFinite(a) ? [a, b] : null)} />
    <${Events} bus=${bus} />
    <p class="small">This view keeps nothing. For a log of every frame, a fault memory and a report run beside it: <code>${logging(site)}</code></p>`;
}

/** The command that follows the same bus, or those of the first interface, and writes a log. */
function logging(site) {
  const all = site.live.map((each) => each.split(/:(.*)/s)), first = all[0][0];
  const channels = all.filter(([name]) => name === first).map(([, channel]) => ` --channel ${channel}`).join("");
  return `tierod live --interface ${first}${channels}${site.dbc.map((each) => ` --dbc ${each}`).join("")} --vehicle ${site.vehicle.split("/").pop()} --log drive.mf4`;
}

function State({ bus }) {
  const s = bus.state, problems = bus.events.filter((each) => each.event === "problem");
  if (!s && problems.length) return stack`<div class="problem" role="alert">${problems.slice(0, 5).reverse().map((each) => html`<p>${sentence(each.text)}</p>`)}</div>`;
  if (!s) return stack`<p class="card small">Nothing was judged yet: it takes some seconds after the first frame.</p>`;
  const old = Object.entries(s.ages).filter(([, age]) => age > 0.8);
  return stack`<section class="card"><div class="row">${s.monitors.map((m) => html`<span class=${kind(m.status)} title=${m.reason}><b>${m.monitor}</b> <${Badge} status=${m.status} /> <span class="small">since ${clock(m.since)}${m.enabled !== null ? `, learning ${figure(100 * m.enabled, 3)} %` : ""}</span></span>`)}</div>
    <dl class="facts"><div><dt>time</dt><dd>${clock(s.time)}</dd></div><div><dt>frames</dt><dd>${s.frames}</dd></div><div><dt>lost</dt><dd>${s.lost}</dd></div><div><dt>late</dt><dd>${s.late}</dd></div><div><dt>delay to this page</dt><dd>${figure(1000 * bus.delay, 3)} ms</dd></div><div><dt>processor of the judge</dt><dd>${s.load === undefined ? "–" : `${figure(100 * s.load, 3)} %`}</dd></div></dl>
    ${old.length > 0 && html`<p class="note">Not coming any more: ${old.map(([n, age]) => `${n.replaceAll("_", " ")} (${figure(age, 3)} s)`).join(", ")}.</p>`}
    ${s.monitors.filter((m) => m.reason).map((m) => html`<p class="small">${m.monitor}: ${sentence(m.reason)}</p>`)}</section>`;
}

function LivePanels({ address, bus, view, tick, onView }) {
  const list = [...bus.buffers.keys()];
  const signals = useMemo(() => list.map((name) => { const [, label] = UNITS[bus.buffers.get(name).unit] || [1, written(bus.buffers.get(name).unit)]; return { name, title: name.split("/").pop().replaceAll("_", " "), group: name.includes("/") ? `Estimates of ${name.split("/")[0]}` : "Signals", label, meaning: "", source: "", count: "" }; }), [list.length]);
  const chosen = address.signals !== undefined ? parse(address.signals) : ["driver_torque", "steering_wheel_angle", "vehicle_speed", ...list.filter((n) => bus.buffers.has(`${n}_standard_deviation`)).slice(0, 1)].filter((n) => list.includes(n)).map((n) => [n]);
  const shown = chosen.map((p) => p.filter((n) => bus.buffers.has(n))).filter((p) => p.length);
  const names = shown.flat();
  const toggle = (name, into) => set({ signals: write(names.includes(name) ? shown.map((p) => p.filter((n) => n !== name)) : into && shown.length ? shown.map((p, i) => (i === shown.length - 1 ? [...p, name] : p)) : [...shown, [name]]) });
  return stack`<div class="bench"><aside class="side card"><${Tree} signals=${signals} shown=${new Set(names)} onToggle=${toggle} /></aside><div>
    ${!shown.length && !bus.events.some((each) => each.event === "problem") && html`<p class="card">No samples yet: check that the bus is active and the channel is right.</p>`}
    ${shown.map((panel) => html`<${LivePanel} key=${panel.join()} panel=${panel} bus=${bus} view=${view} tick=${tick} onView=${onView} />`)}</div></div>`;
}

const written = (unit) => (unit || "").replaceAll("**2", "²").replaceAll("*", "·");

function LivePanel({ panel, bus, view, tick, onView }) {
  const curves = panel.map((name, at) => {
    const buffer = bus.buffers.get(name), [factor, label] = UNITS[buffer.unit] || [1, written(buffer.unit)];
    const part = buffer.over(view[0], view[1], 1200), scale = (values) => (factor === 1 ? values : values.map((v) => (v === null ? null : v * factor)));
    const lower = scale(part.lower), upper = part.upper === part.lower ? lower : scale(part.upper);
    return { name, title: name.replaceAll("_", " "), label, colour: colour(at), time: part.time, lower, upper };
  });
  const now = (c) => { const v = c.upper[c.upper.length - 1]; return figure(v); };
  return stack`<section class="card panel"><div class="chips">${curves.map((c) => html`<span class="chip"><i style=${{ background: c.colour }}></i>${c.title}${c.label ? ` [${c.label}]` : ""}<output>${now(c)}</output></span>`)}</div>
    <${TimeChart} curves=${curves} view=${view} tick=${tick} height=${170} sync="live" onView=${onView} label=${`${panel.join(", ")}, live`} /></section>`;
}

function Events({ bus }) {
  return stack`<details class="card" open><summary>Events (${bus.events.length})</summary><ul>${bus.events.slice(0, 40).map((e) => html`<li><b>${e.event}</b> ${e.time !== undefined ? clock(e.time) : ""} ${e.monitor || ""} ${e.status ? html`<${Badge} status=${e.status} />` : ""} ${e.text || e.reason || ""}</li>`)}</ul></details>`;
}
