"use strict";
// The time series of a page at several levels, and what charts draw of them.
const series = (() => {
  const MOST = 2000; // bins that a chart draws of the part that it shows; beyond it a coarser level does
  const MISSING = 0;

  async function inflated(text, format) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  // The bins that tierod.core.decimation.pack made.
  function unpacked(head, bytes) {
    const count = head.count, level = empty(head.start, head.width, count);
    const number = (place) => bytes[place] + 256 * bytes[3 * count + place];
    const value = (code) => head.lowest + head.step * (code - 1);
    let middle = 0;
    for (let bin = 0; bin < count; bin++) {
      const turned = number(bin);
      middle = (middle + ((turned >>> 1) ^ -(turned & 1))) & 0xffff;
      if (middle === MISSING) continue;
      level.mean[bin] = value(middle);
      level.upper[bin] = value(middle + number(count + bin));
      level.lower[bin] = value(middle - number(2 * count + bin));
    }
    return level;
  }

  function empty(start, width, count) {
    const part = () => new Float64Array(count).fill(NaN);
    return { start, width, count, lower: part(), upper: part(), mean: part() };
  }

  // Two neighbouring bins as one.
  function halved(level) {
    const half = empty(level.start, 2 * level.width, Math.ceil(level.count / 2));
    for (let bin = 0; bin < level.count; bin++) {
      if (Number.isNaN(level.mean[bin])) continue;
      const at = bin >> 1, other = bin % 2 === 1 && !Number.isNaN(half.mean[at]);
      half.lower[at] = other ? Math.min(half.lower[at], level.lower[bin]) : level.lower[bin];
      half.upper[at] = other ? Math.max(half.upper[at], level.upper[bin]) : level.upper[bin];
      half.mean[at] = other ? 0.5 * (half.mean[at] + level.mean[bin]) : level.mean[bin];
    }
    return half;
  }

  // All levels of a series, the finest first.
  function levels(finest) {
    const found = [finest];
    while (found[found.length - 1].count > MOST) found.push(halved(found[found.length - 1]));
    return found;
  }

  // Bins from one end of the recording to the other: fine ones where the chart is zoomed to, coarse ones elsewhere.
  function bins(all, view) {
    const coarse = all[all.length - 1];
    if (!view || view.from <= coarse.start && view.to >= coarse.start + coarse.count * coarse.width) return all_of(coarse);
    const room = view.to - view.from;
    const fine = all.find((level) => room <= MOST * level.width) || coarse;
    if (fine === coarse) return all_of(coarse);
    const ratio = Math.round(coarse.width / fine.width);
    const at = (time) => Math.min(Math.max(Math.floor((time - coarse.start) / coarse.width), 0), coarse.count);
    const first = at(view.from - 0.5 * room), last = at(view.to + 0.5 * room) + 1;
    return [
      ...stretch(coarse, 0, first),
      ...stretch(fine, first * ratio, Math.min(last * ratio, fine.count)),
      ...stretch(coarse, last, coarse.count),
    ];
  }
  const all_of = (level) => stretch(level, 0, level.count);
  function stretch(level, first, last) {
    const found = [];
    for (let bin = first; bin < last; bin++) {
      const time = level.start + (bin + 0.5) * level.width;
      found.push({ time, lower: level.lower[bin], upper: level.upper[bin], mean: level.mean[bin] });
    }
    return found;
  }

  // What another series has at the times of some bins, which are asked for one after the other.
  function beside(all, view, part) {
    const known = bins(all, view);
    let place = 0;
    return (time) => {
      const away = (bin) => Math.abs(known[bin].time - time);
      while (place + 1 < known.length && away(place + 1) <= away(place)) place++;
      return known.length ? known[place][part] : NaN;
    };
  }

  const seen = (value) => (Number.isNaN(value) ? null : value);

  // A closed outline for each stretch in which both edges are known.
  function outline(parts) {
    const x = [], y = [];
    let run = [];
    const close = () => {
      if (run.length && x.length) { x.push(null); y.push(null); }
      for (const [time, , high] of run) { x.push(time); y.push(high); }
      for (const [time, low] of run.reverse()) { x.push(time); y.push(low); }
      run = [];
    };
    for (const part of parts) {
      if (Number.isNaN(part[1]) || Number.isNaN(part[2])) close();
      else run.push(part);
    }
    close();
    return { x, y };
  }

  // The extreme of a bin where it is beyond a limit: [level, whether the rule acts below it].
  function beyond(bin, limits) {
    const passed = limits.find(([level, low]) => (low ? bin.lower <= level : bin.upper >= level));
    return passed ? (passed[1] ? bin.lower : bin.upper) : NaN;
  }

  // What a mark of a chart draws: x and y, or z of several rows.
  function drawn(store, meta, view) {
    const f = meta.factor, scale = meta.per_second;
    if (meta.part === "rows") return rows(store, meta, view);
    const found = bins(store[meta.series], view);
    if (meta.part === "range") return outline(found.map((bin) => [bin.time * scale, f * bin.lower, f * bin.upper]));
    if (meta.part === "interval") {
      const deviation = beside(store[meta.deviation], view, "mean");
      return outline(found.map((bin) => {
        const half = meta.deviations * deviation(bin.time);
        return [bin.time * scale, f * (bin.mean - half), f * (bin.mean + half)];
      }));
    }
    const absent = meta.absent === undefined ? NaN : meta.absent;
    const value = meta.part === "beyond"
      ? (bin) => beyond(bin, meta.limits)
      : (bin) => (Number.isNaN(bin.mean) ? absent : bin.mean);
    return { x: found.map((bin) => bin.time * scale), y: found.map((bin) => seen(f * value(bin))) };
  }

  function rows(store, meta, view) {
    const times = bins(store[meta.rows[0]], view).map((bin) => bin.time);
    const near = (value) => meta.meanings.find(([code]) => value !== null && Math.abs(code - value) < 0.01);
    const z = meta.rows.map((name) => times.map(beside(store[name], view, "upper")).map(seen));
    const text = z.map((row) => row.map((value) => (near(value) || [0, meta.otherwise])[1]));
    return { x: times.map((time) => time * meta.per_second), z, text };
  }

  async function store(heads) {
    const found = {};
    for (const [name, head] of Object.entries(heads)) {
      found[name] = levels(unpacked(head, await inflated(head.data, "deflate")));
    }
    return found;
  }

  return { inflated, unpacked, halved, levels, drawn, store };
})();
