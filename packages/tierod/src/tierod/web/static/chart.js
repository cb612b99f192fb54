// Charts over time on uPlot: bands, limits, synchronised cursor and zoom, wheel, drag and keys.
import { html, useLayoutEffect, useRef } from "./html.js";
import { clock, figure } from "./parts.js";

const root = () => getComputedStyle(document.documentElement);
export const token = (name) => root().getPropertyValue(`--${name}`).trim();
/** Of a curve, as a name: what it stands for changes with the theme. */
export const colour = (at) => `var(--s${(at % 6) + 1})`;
const ink = (name) => token(name.slice(6, -1));
const clear = (hex, share) => {
  const n = parseInt(hex.slice(1), 16);
  return `rgba(${n >> 16},${(n >> 8) & 255},${n & 255},${share})`;
};

/** Redraw where the looks change: theme and width. */
export function useUplot(make, keys) {
  const place = useRef(null), made = useRef(null);
  useLayoutEffect(() => {
    const build = () => {
      if (made.current) made.current.destroy();
      made.current = place.current ? make(place.current, Math.max(place.current.clientWidth, 120)) : null;
    };
    build();
    const onTheme = () => build();
    addEventListener("tierod-theme", onTheme);
    const resize = new ResizeObserver(() => {
      const width = place.current && place.current.clientWidth;
      if (made.current && width && Math.abs(width - made.current.width) > 1) made.current.setSize({ width, height: made.current.height });
    });
    resize.observe(place.current);
    return () => {
      resize.disconnect();
      removeEventListener("tierod-theme", onTheme);
      if (made.current) made.current.destroy();
      made.current = null;
    };
  }, keys);
  return [place, made];
}

export function axis(more) {
  return { stroke: token("muted"), grid: { stroke: token("line"), width: 0.6 }, ticks: { stroke: token("line"), width: 1, size: 5 }, font: "12px system-ui, sans-serif", ...more };
}

const minutes = (v) => { const s = Math.round(Math.abs(v)); return `${v < 0 ? "−" : ""}${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}`; };
const timeText = (self, values) => values.map((v) => (Math.abs(values[values.length - 1]) < 120 || values[1] - values[0] < 1 ? `${figure(v, 7)} s` : Math.abs(v) < 3600 ? minutes(v) : clock(v)));

/** Nearest place of a time in rising times. */
export function nearest(times, at) {
  let low = 0, high = times.length - 1;
  while (high - low > 1) { const mid = (low + high) >> 1; if (times[mid] < at) low = mid; else high = mid; }
  return Math.abs((times[low] ?? Infinity) - at) <= Math.abs((times[high] ?? Infinity) - at) ? low : high;
}

/** Whether the samples of a curve stand so far apart in the picture that each is shown as a point. */
function sparse(u, at) {
  const [first, last] = u.series[0].idxs;
  let count = 0;
  for (let i = first; i <= last && count <= 200; i++) if (u.data[at][i] !== null && u.data[at][i] !== undefined) count++;
  return count > 0 && count * 12 < u.width;
}

/** Curves on one time axis: [{name, title, label, colour, dashed, time, lower, upper, band}] -> uPlot data and series. */
function tables(curves) {
  const parts = [], series = [{}], bands = [], drawnAt = new Map();
  const scales = [...new Set(curves.map((c) => c.label || "1"))];
  for (const c of curves) {
    const scale = c.label || "1", at = series.length, binned = c.lower !== c.upper, shade = ink(c.colour);
    const line = { scale, stroke: shade, width: 1.2, points: { show: false }, spanGaps: false, dash: c.dashed ? [6, 4] : undefined };
    if (!binned) line.points = { show: sparse, size: 4, fill: shade, stroke: shade };
    parts.push([c.time, c.lower, ...(binned ? [c.upper] : []), ...(c.band ? [c.band.lower, c.band.upper] : [])]);
    if (binned) {
      series.push({ ...line, paths: () => null }, { ...line, paths: () => null });
      drawnAt.set(at + 1, { ...c, shade });
    } else series.push(line);
    if (c.band) {
      const edge = { scale, stroke: clear(shade, 0.35), width: 0.6, points: { show: false }, spanGaps: false, auto: false }, next = series.length;
      series.push({ ...edge }, { ...edge });
      bands.push({ series: [next + 1, next], fill: clear(shade, 0.15) });
    }
  }
  const alike = parts.every(([time]) => time.length === parts[0][0].length && time[0] === parts[0][0][0] && time[time.length >> 1] === parts[0][0][time.length >> 1] && time[time.length - 1] === parts[0][0][time.length - 1]);
  const data = alike ? [parts[0][0], ...parts.flatMap((p) => p.slice(1))] : uPlot.join(parts, parts.map((p) => p.map(() => 2)));
  return { data, series, bands, scales, drawnAt };
}

/** Lowest to highest of every bin as a bar one column of pixels wide, which meets its neighbour: a line of all samples. */
function columns(u, c) {
  const { ctx, bbox } = u, x = u.scales.x, y = u.scales[c.label || "1"], n = c.time.length;
  const perX = bbox.width / (x.max - x.min), perY = bbox.height / (y.max - y.min), thick = Math.max(1, Math.round(1.2 * devicePixelRatio));
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.fillStyle = c.shade;
  ctx.globalAlpha = c.dashed ? 0.65 : 1;
  let column = NaN, low = Infinity, high = -Infinity, before = null;
  const flush = (next) => {
    if (low > high) return;
    let a = low, b = high;
    if (before) { if (before[1] < a) a = before[1]; if (before[0] > b) b = before[0]; }
    const top = bbox.top + bbox.height - (b - y.min) * perY, height = (b - a) * perY;
    ctx.fillRect(column, Math.round(top - 0.5 * thick), Math.max(next - column, thick), Math.max(Math.round(height), 0) + thick);
    before = [low, high];
    low = Infinity;
    high = -Infinity;
  };
  for (let at = Math.max(nearest(c.time, x.min) - 1, 0); at < n; at++) {
    const px = Math.round(bbox.left + (c.time[at] - x.min) * perX);
    if (c.lower[at] === null) { flush(column + 1); before = null; continue; } // a bin before a pause does not reach into it
    if (px !== column) { flush(px); column = px; }
    if (px > bbox.left + bbox.width) break;
    if (c.lower[at] < low) low = c.lower[at];
    if (c.upper[at] > high) high = c.upper[at];
  }
  flush(column + 1);
  ctx.restore();
}

/** What lies behind and over the curves: stretches in which a monitor learnt, limits, moments, the measuring cursors. */
function drawn(props) {
  return (u) => {
    const { ctx, bbox } = u, { levels = [], moments = [], stretches = [], measured = {} } = props.current;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
    for (const [from, to] of stretches) {
      const x = u.valToPos(from, "x", true), w = u.valToPos(to, "x", true) - x;
      ctx.fillStyle = clear(token("accent"), 0.55);
      ctx.fillRect(x, bbox.top + bbox.height - 4 * devicePixelRatio, Math.max(w, 1), 4 * devicePixelRatio);
    }
    const shown = levels.filter(({ scale }) => u.scales[scale])
      .map(({ value, label, scale }) => ({ y: u.valToPos(value, scale, true), label })).sort((a, b) => a.y - b.y);
    let names = [];
    shown.forEach(({ y, label }, at) => {
      // Of lines so near to each other that their names would overlap, the last one names all.
      names.push(label);
      const last = at + 1 === shown.length || shown[at + 1].y - y > 13 * devicePixelRatio;
      rule(ctx, token("bad"), bbox.left, y, bbox.left + bbox.width, y, last ? names.join(", ") : "");
      if (last) names = [];
    });
    for (const { time, label } of moments) upright(u, time, token("warn"), label);
    for (const name of ["a", "b"]) if (Number.isFinite(measured[name])) upright(u, measured[name], token("accent"), name.toUpperCase());
    ctx.restore();
  };
}

function rule(ctx, stroke, x1, y1, x2, y2, label) {
  ctx.strokeStyle = stroke;
  ctx.fillStyle = stroke;
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash([7 * devicePixelRatio, 4 * devicePixelRatio]);
  ctx.beginPath();
  ctx.moveTo(x1, y1);
  ctx.lineTo(x2, y2);
  ctx.stroke();
  ctx.setLineDash([]);
  if (!label) return;
  ctx.textAlign = x1 === x2 ? "left" : "right";
  const below = x1 === x2 || y1 < 26 * devicePixelRatio; // no room above a line at the top
  ctx.fillText(label, (x1 === x2 ? x1 : x2) + (x1 === x2 ? 4 : -6) * devicePixelRatio, y1 + (below ? 13 : -4) * devicePixelRatio);
}

function upright(u, time, stroke, label) {
  const x = u.valToPos(time, "x", true);
  rule(u.ctx, stroke, x, u.bbox.top, x, u.bbox.top + u.bbox.height, label);
}

/** The wheel zooms, dragging with shift or the middle button pans. */
function gestures(u, props) {
  const over = u.over;
  over.addEventListener("wheel", (event) => {
    event.preventDefault();
    const { left, width } = over.getBoundingClientRect();
    const [from, to] = props.current.view, share = (event.clientX - left) / width, at = from + share * (to - from);
    if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) return shift(props, event.deltaX / width);
    const by = Math.exp(Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 60) * 0.005);
    return props.current.onView(at - share * (to - from) * by, at + (1 - share) * (to - from) * by);
  }, { passive: false });
  let last = null;
  over.addEventListener("pointerdown", (event) => {
    if (!(event.shiftKey || event.button === 1 || event.pointerType === "touch")) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    last = event.clientX;
    over.setPointerCapture(event.pointerId);
  }, true);
  over.addEventListener("mousedown", (event) => { if (event.shiftKey || event.button === 1) event.stopImmediatePropagation(); }, true);
  over.addEventListener("pointermove", (event) => {
    if (last === null) return;
    shift(props, (last - event.clientX) / over.clientWidth);
    last = event.clientX;
  });
  for (const name of ["pointerup", "pointercancel"]) over.addEventListener(name, () => { last = null; });
}

function shift(props, share) {
  const [from, to] = props.current.view;
  props.current.onView(from + share * (to - from), to + share * (to - from));
}

function keyed(props) {
  return (event) => {
    const [from, to] = props.current.view, middle = (from + to) / 2, half = (to - from) / 2;
    const at = Number.isFinite(props.current.at()) ? props.current.at() : middle;
    const acts = {
      ArrowLeft: () => shift(props, -0.15), ArrowRight: () => shift(props, 0.15),
      "+": () => props.current.onView(middle - half / 1.5, middle + half / 1.5), "=": () => props.current.onView(middle - half / 1.5, middle + half / 1.5),
      "-": () => props.current.onView(middle - half * 1.5, middle + half * 1.5),
      Home: () => props.current.onView(-Infinity, Infinity), 0: () => props.current.onView(-Infinity, Infinity),
      a: () => props.current.onMeasure("a", at), b: () => props.current.onMeasure("b", at),
    };
    const act = acts[event.key];
    if (act && !event.ctrlKey && !event.metaKey) { event.preventDefault(); act(); }
  };
}

/** One panel: curves over the common time axis. */
export function TimeChart(given) {
  const { curves, view, height = 180, label } = given;
  const props = useRef(given), now = useRef(null), drawnCurves = useRef(null), bars = useRef(new Map()), measured = given.measured || {};
  props.current = { onView: () => {}, onCursor: () => {}, onMeasure: () => {}, at: () => now.current, ...given };
  const shape = curves.map((c) => [c.name, c.label, c.colour, c.dashed, !!c.band, c.lower === c.upper].join("|")).join("\n");
  const [place, made] = useUplot((target, width) => {
    const { data, series, bands, scales, drawnAt } = tables(props.current.curves);
    bars.current = drawnAt;
    drawnCurves.current = props.current.curves;
    const own = Object.fromEntries(scales.map((s) => [s, { auto: true, range: (self, low, high) => ranged(self, ...withBands(self, bands, s, low, high)) }]));
    const u = new uPlot({
      width, height, series, bands, padding: [8, 8, 0, 0],
      scales: { x: { time: false, auto: false, min: props.current.view[0], max: props.current.view[1] }, ...own },
      axes: [axis({ values: timeText, size: 34 }), ...scales.slice(0, 2).map((s, at) => axis({ scale: s, side: at ? 1 : 3, size: 62, label: s === "1" ? undefined : s, labelSize: 16, labelFont: "12px system-ui, sans-serif", grid: at ? { show: false } : { stroke: token("line"), width: 0.6 }, values: (_, v) => v.map((x) => figure(x, 5)) }))],
      legend: { show: false },
      cursor: { sync: { key: props.current.sync || "tierod", scales: ["x", null] }, drag: { x: true, y: false, setScale: false, uni: 20 }, focus: { prox: -1 }, points: { show: false }, y: false, bind: { dblclick: () => () => { props.current.onView(-Infinity, Infinity); return null; } } },
      hooks: {
        draw: [drawn(props)],
        drawSeries: [(self, at) => { const c = bars.current.get(at); if (c) columns(self, c); }],
        setSelect: [(self) => {
          const { left, width: w } = self.select;
          if (w > 4) { const from = self.posToVal(left, "x"), to = self.posToVal(left + w, "x"); self.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false); props.current.onView(from, to); }
        }],
        setCursor: [(self) => {
          now.current = self.cursor.left >= 0 ? self.posToVal(self.cursor.left, "x") : NaN;
          props.current.onCursor(now.current);
        }],
        ready: [(self) => gestures(self, props)],
      },
    }, data, target);
    return u;
  }, [shape, height]);
  useLayoutEffect(() => {
    const u = made.current;
    if (!u) return;
    if (drawnCurves.current !== curves) {
      const { data, drawnAt } = tables(curves);
      bars.current = drawnAt;
      u.batch(() => { u.setData(data, false); u.setScale("x", { min: view[0], max: view[1] }); });
      drawnCurves.current = curves;
    } else u.setScale("x", { min: view[0], max: view[1] });
  }, [curves, view[0], view[1], measured.a || 0, measured.b || 0, given.levels, given.stretches, given.moments]);
  return html`<div class="plot" ref=${place} tabindex="0" role="application" aria-label=${label} aria-roledescription="chart" onKeyDown=${keyed(props)}></div>`;
}

/** The range of the curves, widened so that most of each band is in it, up to eight times: a band says how well a curve is known. */
function withBands(u, bands, scale, low, high) {
  if (low === null || high === null || !Number.isFinite(low)) return [low, high];
  const room = 8 * (high - low), [first, last] = u.series[0].idxs;
  let [least, most] = [low, high];
  for (const { series: [above, below] } of bands) {
    if (u.series[above].scale !== scale) continue;
    const edge = (at, share) => { const found = u.data[at].slice(first, last + 1).filter((v) => v !== null && v !== undefined).sort((a, b) => a - b); return found[Math.floor(share * (found.length - 1))]; };
    least = Math.min(least, Math.max(edge(below, 0.1) ?? low, low - room));
    most = Math.max(most, Math.min(edge(above, 0.9) ?? high, high + room));
  }
  return [least, most];
}

function ranged(u, low, high) {
  if (low === null || high === null || !Number.isFinite(low)) return [0, 1];
  if (low === high) { const pad = Math.abs(low) * 0.05 || 1; return [low - pad, high + pad]; }
  const pad = 0.06 * (high - low);
  return [low - pad, high + pad];
}

/** Points with their error bars, a band and levels over days: a trend. */
export function TrendChart({ days, values, errors, band, levels = [], unit, label, height = 240, onPick, moments = [] }) {
  const props = useRef(null);
  props.current = { levels: levels.map((each) => ({ ...each, scale: "y" })), moments, view: [0, 1] };
  const [place] = useUplot((target, width) => {
    const points = [days, values];
    const parts = band ? [points, [band.days, band.lower, band.middle, band.upper]] : [points];
    const data = parts.length === 1 ? points : uPlot.join(parts);
    const blue = token("s1"), red = token("s2");
    const series = [{}, { stroke: blue, width: 0, paths: () => null, points: { show: true, size: 5, fill: blue, stroke: blue } }];
    if (band) series.push({ stroke: clear(red, 0.3), width: 1, spanGaps: true }, { stroke: red, width: 1.6, spanGaps: true }, { stroke: clear(red, 0.3), width: 1, spanGaps: true });
    const shown = levels.map((each) => each.value);
    return new uPlot({
      width, height, series, bands: band ? [{ series: [4, 2], fill: clear(red, 0.16) }] : [],
      scales: { x: { time: true }, y: { range: (u, low, high) => ranged(u, Math.min(low ?? Infinity, ...shown), Math.max(high ?? -Infinity, ...shown)) } },
      axes: [axis({ values: (_, v) => v.map((s) => new Date(1000 * s).toISOString().slice(0, 10)), space: 80 }), axis({ size: 62, label: unit, labelSize: 16, labelFont: "12px system-ui, sans-serif", values: (_, v) => v.map((x) => figure(x, 5)) })],
      legend: { show: false }, cursor: { y: false, points: { show: false } },
      hooks: {
        drawClear: [drawn(props)],
        draw: [(u) => errorBars(u, days, values, errors)],
        ready: [(u) => onPick && u.over.addEventListener("click", () => { const at = u.posToVal(u.cursor.left, "x"); onPick(nearest(days, at)); })],
      },
    }, data, target);
  }, [days, values, band, unit]);
  return html`<div class="plot" ref=${place} role="img" aria-label=${label}></div>`;
}

function errorBars(u, days, values, errors) {
  if (!errors) return;
  const { ctx } = u;
  ctx.save();
  ctx.strokeStyle = clear(token("s1"), 0.45);
  ctx.beginPath();
  days.forEach((day, at) => {
    if (values[at] === null || !errors[at]) return;
    const x = u.valToPos(day, "x", true);
    ctx.moveTo(x, u.valToPos(values[at] - errors[at], "y", true));
    ctx.lineTo(x, u.valToPos(values[at] + errors[at], "y", true));
  });
  ctx.stroke();
  ctx.restore();
}

/** All canvases of some charts as one picture. */
export function picture(place, name) {
  const all = [...place.querySelectorAll(".panel")].map((panel) => ({ canvas: panel.querySelector("canvas"), text: panel.dataset.title })).filter((each) => each.canvas);
  if (!all.length) return;
  const line = 20 * devicePixelRatio, made = document.createElement("canvas");
  made.width = Math.max(...all.map(({ canvas }) => canvas.width));
  made.height = all.reduce((sum, { canvas }) => sum + canvas.height + line, 0);
  const ctx = made.getContext("2d");
  ctx.fillStyle = token("paper");
  ctx.fillRect(0, 0, made.width, made.height);
  let y = 0;
  for (const { canvas, text } of all) {
    ctx.fillStyle = token("ink");
    ctx.font = `${13 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.fillText(text || "", 8 * devicePixelRatio, y + 0.75 * line);
    ctx.drawImage(canvas, 0, y + line);
    y += canvas.height + line;
  }
  made.toBlob((blob) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 5000);
  });
}
