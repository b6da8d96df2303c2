"use strict";
// Draws the figures of the page, and moves the time axes of the linked ones together.
(() => {
  const config = {
    displaylogo: false,
    responsive: true,
    modeBarButtonsToRemove: ["sendChartToCloud", "lasso2d", "select2d"],
  };
  const linked = [];
  let busy = false;

  function follow(source, change) {
    const auto = change["xaxis.autorange"];
    const low = change["xaxis.range[0]"] ?? change["xaxis.range"]?.[0];
    const high = change["xaxis.range[1]"] ?? change["xaxis.range"]?.[1];
    if (busy || (low === undefined && !auto)) return;
    busy = true;
    const range = auto ? source.layout.xaxis.range : [low, high];
    const others = linked.filter((plot) => plot !== source);
    Promise.all(others.map((plot) => Plotly.relayout(plot, { "xaxis.range": [...range] })))
      .finally(() => { busy = false; });
  }

  function choose(plot, group, groups) {
    const size = plot.data.length / groups;
    Plotly.restyle(plot, { visible: plot.data.map((_, i) => Math.floor(i / size) === group) });
  }

  for (const script of document.querySelectorAll("script[data-figure]")) {
    const figure = JSON.parse(script.textContent);
    const plot = document.getElementById(script.dataset.figure);
    Plotly.newPlot(plot, figure.data, figure.layout, config);
    if (plot.dataset.linked === "yes") {
      linked.push(plot);
      plot.on("plotly_relayout", (change) => follow(plot, change));
    }
    const select = document.querySelector(`select[data-for="${plot.id}"]`);
    select?.addEventListener("change", () => choose(plot, select.selectedIndex, select.length));
  }
})();
