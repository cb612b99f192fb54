"use strict";
(() => {
  const PRINTED_WIDTH = 680; // A4 and Letter less their margins
  const HALF = { width: 330, height: 340 }; // two charts beside each other
  const printed = (height) => Math.round(height * (height > 600 ? 0.69 : 0.76));
  const STEP = 0.01; // of the time shown, by which a key moves the cursor
  const root = document.documentElement;
  // A finger that scrolls the page must not zoom the chart under it.
  const touch = window.matchMedia("(pointer: coarse)").matches;
  const settings = {
    responsive: true,
    displaylogo: false,
    displayModeBar: touch || window.innerWidth < 700 ? false : "hover",
    modeBarButtonsToRemove: ["lasso2d", "select2d"],
  };

  const store = {};
  const undrawn = []; // in closed folds
  const charts = []; // { figure, place, line } of every chart that is drawn
  const content = (name) => document.getElementById(name).textContent;
  const packed = (mark) => mark.meta && !mark.x;

  // The library runs as a script of the page, and needs no network.
  async function unfold() {
    const library = document.createElement("script");
    library.textContent = new TextDecoder().decode(await series.inflated(content("library"), "gzip"));
    document.head.append(library);
    Object.assign(store, await series.store(JSON.parse(content("series"))));
    for (const script of document.querySelectorAll("script.figure")) prepare(JSON.parse(script.textContent));
  }

  // Colours are named in a chart by the properties of the style, which differ between light and dark.
  function coloured(value, style) {
    if (typeof value === "string") return value.startsWith("var(--") ? style.getPropertyValue(value.slice(4, -1)).trim() : value;
    if (Array.isArray(value)) return value.every((each) => typeof each === "number") ? value : value.map((each) => coloured(each, style));
    if (value === null || typeof value !== "object" || ArrayBuffer.isView(value)) return value;
    return Object.fromEntries(Object.entries(value).map(([key, each]) => [key, key === "meta" ? each : coloured(each, style)]));
  }
  function marks(figure, view) {
    return figure.data.map((mark) => (packed(mark) ? { ...mark, ...series.drawn(store, mark.meta, view) } : mark));
  }

  // A chart in a closed fold is drawn when that opens.
  function prepare(figure) {
    const place = document.getElementById("chart-" + figure.name);
    download(figure, place);
    if (touch) figure.layout.dragmode = false;
    const fold = place.closest("details:not([open])");
    if (!fold) return draw(figure, place);
    fold.addEventListener("toggle", () => draw(figure, place), { once: true });
    undrawn.push([figure, place]);
  }

  function draw(figure, place) {
    if (place.data) return;
    const style = getComputedStyle(root);
    Plotly.newPlot(place, coloured(marks(figure, null), style), coloured(figure.layout, style), settings);
    const chart = { figure, place };
    charts.push(chart);
    if (figure.timed) follow(chart);
  }

  // All charts again, in the colours and the sizes of now.
  function redraw(size) {
    const style = getComputedStyle(root);
    for (const { figure, place } of charts) {
      const layout = coloured(figure.layout, style), seen = place.layout.xaxis && place.layout.xaxis.range;
      if (figure.timed && seen) layout.xaxis.range = [...seen];
      if (size) Object.assign(layout, size(place, figure.layout.height));
      place.style.height = layout.height + "px";
      Plotly.react(place, coloured(marks(figure, figure.timed ? ends(figure, seen) : null), style), layout, settings);
    }
  }
  function ends(figure, range) {
    const mark = figure.data.find((each) => each.meta);
    if (!mark || !range) return null;
    const [first, last] = range.map((end) => end / mark.meta.per_second);
    return { from: Math.min(first, last), to: Math.max(first, last) };
  }

  // All charts over the time of the recording show the same part of it, in more detail, and the same moment.
  function follow(chart) {
    const { figure, place } = chart;
    const fine = figure.data.map((mark, index) => (packed(mark) ? index : -1)).filter((index) => index >= 0);
    place.on("plotly_relayout", (change) => {
      if (!Object.keys(change).some((key) => key.startsWith("xaxis."))) return;
      const seen = [...place.layout.xaxis.range];
      refine(chart, fine, seen);
      if (chart.led) return;
      for (const other of charts) {
        if (other === chart || !other.figure.timed) continue;
        other.led = true;
        Plotly.relayout(other.place, { "xaxis.range": [...seen] }).then(() => { other.led = false; });
      }
    });
    chart.line = document.createElement("div");
    chart.line.className = "cursor";
    chart.line.hidden = true;
    place.append(chart.line);
    place.on("plotly_hover", (event) => point(chart, event.xvals ? event.xvals[0] : event.points[0].x));
    place.on("plotly_unhover", () => point(chart, null));
    place.tabIndex = 0;
    place.addEventListener("keydown", (event) => step(chart, event));
    place.addEventListener("blur", () => point(null, null));
  }

  function refine({ figure, place }, fine, range) {
    const change = {}, view = ends(figure, range);
    for (const index of fine) {
      const drawn = series.drawn(store, figure.data[index].meta, view);
      for (const key of ["x", "y", "z", "text"]) (change[key] ||= []).push(drawn[key] || place.data[index][key]);
    }
    if (fine.length) Plotly.restyle(place, change, fine);
  }

  // The moment under the cursor, in every chart over time, with its values in those that are in sight.
  let moment = null, waiting = false;
  function point(from, time) {
    moment = { from, time };
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      for (const chart of charts) if (chart.line) mark(chart, moment.time, chart !== moment.from);
    });
  }
  function mark({ place, line }, time, led) {
    const axis = place._fullLayout.xaxis, at = axis.d2p(time), box = place._fullLayout._size;
    line.hidden = time === null || at < 0 || at > axis._length;
    if (!line.hidden) {
      line.style.left = axis._offset + at + "px";
      line.style.top = box.t + "px";
      line.style.height = box.h + "px";
    }
    if (!led) return;
    const { top, bottom } = place.getBoundingClientRect();
    if (line.hidden || bottom < 0 || top > window.innerHeight) return Plotly.Fx.unhover(place, undefined, undefined, true);
    Plotly.Fx.hover(place, { xval: time }, Object.keys(place._fullLayout._plots), true);
  }
  function step(chart, event) {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === "Escape") point(null, null);
    if (!way) return;
    const [first, last] = chart.place.layout.xaxis.range, now = moment && moment.time !== null ? moment.time : 0.5 * (first + last);
    point(null, Math.min(Math.max(now + way * (event.shiftKey ? 10 : 1) * STEP * (last - first), first), last));
    event.preventDefault();
  }

  function download(figure, place) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "link";
    button.textContent = "Data (CSV)";
    button.setAttribute("aria-label", "Data of the chart as CSV: " + place.getAttribute("aria-label"));
    button.addEventListener("click", () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([csv.text(figure, store)], { type: "text/csv" }));
      link.download = figure.name + ".csv";
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
    place.closest("figure").querySelector(".more").append(button);
  }

  function excuse(reason) {
    const note = document.createElement("p");
    note.className = "warning";
    note.textContent = "The charts cannot be drawn: " + reason + ". All verdicts and tables stand without them.";
    document.querySelector("figure").before(note);
  }

  function printedSize(place, height) {
    const pair = place.closest(".pair");
    const halved = pair && pair.querySelectorAll(".chart").length > 1;
    const [width, tall] = halved ? [HALF.width, Math.min(height, HALF.height)] : [PRINTED_WIDTH, printed(height)];
    return { width, height: tall, autosize: false };
  }
  const folded = document.querySelectorAll("details.keep:not([open])");
  const theme = root.dataset.theme;
  window.addEventListener("beforeprint", () => {
    for (const each of folded) each.open = true;
    for (const each of undrawn.splice(0)) draw(...each);
    root.dataset.theme = "light";
    redraw(printedSize);
  });
  window.addEventListener("afterprint", () => {
    for (const each of folded) each.open = false;
    if (theme) root.dataset.theme = theme;
    else delete root.dataset.theme;
    redraw();
  });
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => redraw());
  if (!window.DecompressionStream) {
    excuse("this browser is too old to unpack them; Chrome 80, Edge 80, Firefox 113 and Safari 16.4 are not");
  } else {
    unfold().catch((error) => excuse("the page is damaged (" + error + "); write it again"));
  }
})();
