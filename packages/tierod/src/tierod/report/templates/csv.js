"use strict";
// The data of a chart as text with commas.
const csv = (() => {
  // A name that a spreadsheet would take for a formula begins with an apostrophe.
  function cell(value) {
    if (value === null || value === undefined || Number.isNaN(value)) return "";
    if (typeof value === "number") return String(value);
    const text = /^[=+\-@\t\r]/.test(value) ? "'" + value : String(value);
    return /[",\n\r]/.test(text) ? '"' + text.replace(/"/g, '""') + '"' : text;
  }
  const table = (rows) => rows.map((row) => row.map(cell).join(",")).join("\r\n") + "\r\n";
  const title = (axis) => (axis && axis.title && axis.title.text) || "";
  const short = (value) => (Number.isFinite(value) ? Number(value.toPrecision(6)) : value);

  // Series of the page, at the finest level that it holds.
  function series_rows(figure, store) {
    const rows = [["series", "unit", "time [s]", "lowest", "mean", "highest"]], known = new Set();
    for (const mark of figure.data) {
      const meta = mark.meta || {};
      for (const name of [meta.series, meta.deviation, ...(meta.rows || [])]) {
        if (!name || known.has(name) || !store[name]) continue;
        known.add(name);
        const level = store[name][0], f = meta.factor || 1;
        for (let bin = 0; bin < level.count; bin++) {
          const time = short(level.start + (bin + 0.5) * level.width);
          const values = [level.lower[bin], level.mean[bin], level.upper[bin]];
          if (!Number.isNaN(values[1])) rows.push([name, meta.unit || "", time, ...values.map((value) => short(f * value))]);
        }
      }
    }
    return rows;
  }

  // Points as they are drawn, with the titles of their axes.
  function point_rows(figure) {
    const rows = [["series", "along", "x", "up", "y", "low", "high"]];
    const layout = figure.layout;
    for (const mark of figure.data) {
      if (mark.meta && mark.meta.series || !mark.x) continue;
      const along = title(layout[(mark.xaxis || "x").replace("x", "xaxis")]);
      const up = title(layout[(mark.yaxis || "y").replace("y", "yaxis")]);
      const name = mark.name || "";
      if (mark.z) {
        mark.y.forEach((down, row) => mark.x.forEach((across, at) => rows.push([name, along, across, down, mark.z[row][at], "", ""])));
        continue;
      }
      const spread = mark.error_y || mark.error_x || {}, middle = mark.y || mark.median || [];
      const end = (at, part, sign) => (spread[part] ? short((mark.error_y ? mark.y[at] : mark.x[at]) + sign * spread[part][at]) : "");
      mark.x.forEach((x, at) => {
        const low = mark.q1 ? mark.q1[at] : end(at, "arrayminus", -1);
        const high = mark.q3 ? mark.q3[at] : end(at, "array", 1);
        if (x !== null) rows.push([name, along, x, up, middle[at], low, high]);
      });
    }
    return rows;
  }

  function text(figure, store) {
    const rows = series_rows(figure, store), points = point_rows(figure);
    const tables = [rows, points].filter((part) => part.length > 1).map(table);
    return "\ufeff" + tables.join("\r\n");
  }

  return { text };
})();
