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

  for (const script of document.querySelectorAll("script.figure")) {
    const figure = JSON.parse(script.textContent);
    const place = document.getElementById("chart-" + figure.name);
    if (touch) figure.layout.dragmode = false;
    place.dataset.height = figure.layout.height;
    Plotly.newPlot(place, figure.data, figure.layout, settings);
    charts.push(place);
    if (figure.timed) follow(place);
  }

  // All charts over the time of the recording show the same part of it.
  function follow(place) {
    place.dataset.timed = "yes";
    place.on("plotly_relayout", (change) => {
      const from = change["xaxis.range[0]"], to = change["xaxis.range[1]"];
      if (place.dataset.led || (from === undefined && !change["xaxis.autorange"])) return;
      const wanted = from === undefined ? { "xaxis.autorange": true } : { "xaxis.range": [from, to] };
      for (const other of charts) {
        if (other === place || !other.dataset.timed) continue;
        other.dataset.led = "yes";
        Plotly.relayout(other, wanted).then(() => delete other.dataset.led);
      }
    });
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
})();
