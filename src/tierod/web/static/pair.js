// Two signals against each other over the visible stretch: hysteresis, and any other pair.
import { html, useEffect, useMemo, useRef } from "./html.js";
import { get } from "./api.js";
import { set } from "./address.js";
import { token } from "./chart.js";
import { figure, Trouble, useFetched } from "./parts.js";

export function PairChart({ address, signals, byName, seriesKey, result, view }) {
  const along = byName.get(address.x), up = byName.get(address.y);
  const options = (now) => html`<option value="">–</option>${signals.map((s) => html`<option value=${s.name} selected=${now === s.name}>${s.group.startsWith("Estimates") ? s.name : s.title}${s.label ? ` [${s.label}]` : ""}</option>`)}`;
  const usual = byName.has("steering_wheel_angle") && byName.has("driver_torque");
  const choices = useMemo(() => html`<label>along <select onChange=${(e) => set({ x: e.target.value })}>${options(address.x)}</select></label><label>up <select onChange=${(e) => set({ y: e.target.value })}>${options(address.y)}</select></label>`, [signals, address.x, address.y]);
  const found = useFetched((signal) => (along && up ? new Promise((go) => setTimeout(go, 80)).then(() => get(`/api/series/${seriesKey}/pair`, { along: along.name, up: up.name, result: result ? result.key : "", start: view[0], stop: view[1] }, signal)) : null), [seriesKey, result && result.key, address.x, address.y, view[0], view[1]]);
  return html`<details class="card" open=${!!(along && up)}><summary>One signal against another, over the visible stretch</summary>
    <div class="row tools">${choices}
    ${usual && html`<button onClick=${() => set({ x: "steering_wheel_angle", y: "driver_torque" })}>Hysteresis of the steering</button>`}</div>
    ${found.error && html`<${Trouble} error=${found.error} />`}
    ${along && up && found.data && html`<${Cloud} data=${found.data} along=${along} up=${up} />${found.data.step > 1 && html`<p class="small">One sample of ${found.data.step} is drawn; zoom in for all.</p>`}`}</details>`;
}

function Cloud({ data, along, up }) {
  const place = useRef(null);
  useEffect(() => {
    const draw = () => paint(place.current, data, along, up);
    draw();
    const resize = new ResizeObserver(draw);
    resize.observe(place.current);
    addEventListener("tierod-theme", draw);
    return () => { resize.disconnect(); removeEventListener("tierod-theme", draw); };
  }, [data, along, up]);
  return html`<canvas class="pair" ref=${place} role="img" aria-label=${`${up.title} over ${along.title}`}></canvas>`;
}

function paint(canvas, data, along, up) {
  const ratio = devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight, ctx = canvas.getContext("2d");
  canvas.width = w * ratio;
  canvas.height = h * ratio;
  ctx.scale(ratio, ratio);
  ctx.clearRect(0, 0, w, h);
  const points = data.along.map((x, i) => [x, data.up[i]]).filter(([x, y]) => x !== null && y !== null).map(([x, y]) => [x * along.factor, y * up.factor]);
  ctx.font = "12px system-ui, sans-serif";
  ctx.fillStyle = token("muted");
  if (!points.length) { ctx.fillText("No samples of both in this stretch.", 20, 30); return; }
  const bounds = (k) => { let low = Infinity, high = -Infinity; for (const p of points) { low = Math.min(low, p[k]); high = Math.max(high, p[k]); } const pad = 0.05 * (high - low) || 1; return [low - pad, high + pad]; };
  const [x0, x1] = bounds(0), [y0, y1] = bounds(1), left = 62, right = w - 12, top = 10, bottom = h - 36;
  const px = (x) => left + ((x - x0) / (x1 - x0)) * (right - left), py = (y) => bottom - ((y - y0) / (y1 - y0)) * (bottom - top);
  ctx.strokeStyle = token("line");
  for (const x of ticks(x0, x1)) {
    ctx.beginPath(); ctx.moveTo(px(x), top); ctx.lineTo(px(x), bottom); ctx.stroke();
    ctx.textAlign = "center"; ctx.fillText(figure(x, 3), px(x), bottom + 15);
  }
  for (const y of ticks(y0, y1)) {
    ctx.beginPath(); ctx.moveTo(left, py(y)); ctx.lineTo(right, py(y)); ctx.stroke();
    ctx.textAlign = "right"; ctx.fillText(figure(y, 3), left - 5, py(y) + 4);
  }
  ctx.textAlign = "center";
  ctx.fillText(`${along.title}${along.label ? ` [${along.label}]` : ""}`, (left + right) / 2, h - 5);
  ctx.save(); ctx.translate(12, (top + bottom) / 2); ctx.rotate(-Math.PI / 2); ctx.fillText(`${up.title}${up.label ? ` [${up.label}]` : ""}`, 0, 0); ctx.restore();
  ctx.strokeStyle = token("s1");
  ctx.globalAlpha = points.length > 4000 ? 0.35 : 0.8;
  ctx.beginPath();
  points.forEach(([x, y], i) => (i ? ctx.lineTo(px(x), py(y)) : ctx.moveTo(px(x), py(y))));
  ctx.stroke();
}

/** Round values between two bounds, three to seven of them. */
function ticks(low, high) {
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough)), step = power * [1, 2, 5, 10].find((each) => each * power >= rough);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high; k++) found.push(+(k * step).toPrecision(12));
  return found;
}
