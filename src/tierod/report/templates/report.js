"use strict";
(() => {
  const PRINTED_WIDTH = 680; // A4 and Letter less their margins
  const HALF = { width: 330, height: 340 }; // two charts beside each other
  const printed = (height) => Math.round(height * (height > 600 ? 0.69 : 0.76));
  const charts = [];
  // A finger that scrolls the page must not zoom the chart under it.
  const touch = window.matchMedia("(pointer: coarse)").matches;
  const settings = {
    responsive: true,
    displaylogo: false,
    displayModeBar: touch || window.innerWidth < 700 ? false : "hover",
    modeBarButtonsToRemove: ["lasso2d", "select2d"],
  };

  const store = {};
  const content = (name) => document.getElementById(name).textContent;
  const parsed = (script) => JSON.parse(script.textContent);

  // The library runs as a script of the page, and needs no network.
  async function unfold() {
    const library = document.createElement("script");
    library.textContent = new TextDecoder().decode(await series.inflated(content("library"), "gzip"));
    document.head.append(library);
    Object.assign(store, await series.store(JSON.parse(content("series"))));
    for (const script of document.querySelectorAll("script.figure")) draw(parsed(script));
  }

  function draw(figure) {
    const place = document.getElementById("chart-" + figure.name);
    place.dataset.height = figure.layout.height;
    if (touch) figure.layout.dragmode = false;
    for (const mark of figure.data) if (packed(mark)) Object.assign(mark, series.drawn(store, mark.meta, null));
    Plotly.newPlot(place, figure.data, figure.layout, settings);
    charts.push(place);
    if (figure.timed) follow(place);
  }
  const packed = (mark) => mark.meta && !mark.x;

  // All charts over the time of the recording show the same part of it, and that part in more detail.
  function follow(place) {
    place.dataset.timed = "yes";
    const fine = place.data.map((mark, index) => (mark.meta ? index : -1)).filter((index) => index >= 0);
    const seen = () => [...place.layout.xaxis.range];
    place.on("plotly_relayout", (change) => {
      if (!Object.keys(change).some((key) => key.startsWith("xaxis."))) return;
      refine(place, fine, seen());
      if (place.dataset.led) return;
      for (const other of charts) {
        if (other === place || !other.dataset.timed) continue;
        other.dataset.led = "yes";
        Plotly.relayout(other, { "xaxis.range": seen() }).then(() => delete other.dataset.led);
      }
    });
  }

  function refine(place, fine, range) {
    const change = {};
    for (const index of fine) {
      const meta = place.data[index].meta, ends = range.map((end) => end / meta.per_second);
      const drawn = series.drawn(store, meta, { from: Math.min(...ends), to: Math.max(...ends) });
      for (const key of ["x", "y", "z", "text"]) (change[key] ||= []).push(drawn[key] || place.data[index][key]);
    }
    if (fine.length) Plotly.restyle(place, change, fine);
  }

  function excuse(reason) {
    const note = document.createElement("p");
    note.className = "warning";
    note.textContent = "The charts cannot be drawn: " + reason + ". All verdicts and tables stand without them.";
    document.querySelector("figure").before(note);
  }

  function resize(chart, width, height) {
    chart.style.height = height + "px";
    Plotly.relayout(chart, { width, height, autosize: width === null });
  }
  function printedSize(chart) {
    const pair = chart.closest(".pair"), height = Number(chart.dataset.height);
    const halved = pair && pair.querySelectorAll(".chart").length > 1;
    return halved ? [HALF.width, Math.min(height, HALF.height)] : [PRINTED_WIDTH, printed(height)];
  }
  // A chart that was drawn in a closed fold takes the width of the page when that opens.
  for (const fold of document.querySelectorAll("details.keep")) {
    fold.addEventListener("toggle", () => {
      if (fold.open) for (const chart of fold.querySelectorAll(".chart")) Plotly.Plots.resize(chart);
    });
  }
  const folded = document.querySelectorAll("details.keep:not([open])");
  window.addEventListener("beforeprint", () => {
    for (const each of folded) each.open = true;
    for (const chart of charts) resize(chart, ...printedSize(chart));
  });
  window.addEventListener("afterprint", () => {
    for (const each of folded) each.open = false;
    for (const chart of charts) resize(chart, null, Number(chart.dataset.height));
  });
  if (!window.DecompressionStream) {
    excuse("this browser is too old to unpack them; Chrome 80, Edge 80, Firefox 113 and Safari 16.4 are not");
  } else {
    unfold().catch((error) => excuse("the page is damaged (" + error + "); write it again"));
  }
})();
