"use strict";
// Draws the figures of the page when they come into view, and keeps their time axes together.
// plotly.js takes a second to start: the page is shown first, then the 3-D view, then the plots.
window.LexstackPlots = (() => {
  const config = {
    displaylogo: false,
    responsive: true,
    modeBarButtonsToRemove: ["sendChartToCloud", "lasso2d", "select2d"],
  };
  const scripts = [...document.querySelectorAll("script[data-figure]")];
  const waiting = new Map(scripts.map((script) => [script.dataset.figure, script]));
  const linked = [];
  let range; // of the linked time axes, once somebody has zoomed
  let busy = false;
  let time;

  function follow(source, change) {
    const auto = change["xaxis.autorange"];
    const low = change["xaxis.range[0]"] ?? change["xaxis.range"]?.[0];
    const high = change["xaxis.range[1]"] ?? change["xaxis.range"]?.[1];
    if (busy || (low === undefined && !auto)) return;
    busy = true;
    range = auto ? [...source.layout.xaxis.range] : [low, high];
    const others = linked.filter((plot) => plot !== source);
    Promise.all(others.map((plot) => Plotly.relayout(plot, { "xaxis.range": [...range] })))
      .finally(() => { busy = false; cursor(time); });
  }

  function choose(plot, group, groups) {
    const size = plot.data.length / groups;
    Plotly.restyle(plot, { visible: plot.data.map((_, i) => Math.floor(i / size) === group) });
  }

  function draw(name) {
    const script = waiting.get(name);
    if (!script) return;
    waiting.delete(name);
    const figure = JSON.parse(script.textContent);
    const plot = document.getElementById(name);
    const isLinked = plot.dataset.linked === "yes";
    if (isLinked && range) figure.layout.xaxis.range = [...range];
    Plotly.newPlot(plot, figure.data, figure.layout, config);
    if (isLinked) {
      linked.push(plot);
      plot.on("plotly_relayout", (change) => follow(plot, change));
      plot.on("plotly_click", (event) => document.dispatchEvent(
        new CustomEvent("lexstack-time", { detail: event.points[0].x })));
      plot.append(Object.assign(document.createElement("div"), { className: "cursor" }));
      cursor(time);
    }
    const select = document.querySelector(`select[data-for="${name}"]`);
    select?.addEventListener("change", () => choose(plot, select.selectedIndex, select.length));
  }

  // Shows where a time [s] is in all linked plots.
  function cursor(seconds) {
    time = seconds;
    for (const plot of linked) {
      const axis = plot._fullLayout.xaxis;
      const line = plot.querySelector(".cursor");
      const [low, high] = axis.range;
      const inside = time !== undefined && time >= low && time <= high;
      line.style.display = inside ? "block" : "none";
      line.style.top = `${plot._fullLayout._size.t}px`;
      line.style.left = `${axis._offset + axis._length * (time - low) / (high - low)}px`;
    }
  }

  // What is in view is drawn at once, the rest when the browser has nothing else to do.
  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) draw(entry.target.id);
  }, { rootMargin: "200px" });
  for (const script of scripts) {
    const plot = document.getElementById(script.dataset.figure);
    plot.style.minHeight = `${script.dataset.height}px`;
  }
  const idle = window.requestIdleCallback || ((callback) => setTimeout(callback, 30));
  function rest() {
    const [next] = waiting.keys();
    if (next === undefined) {
      observer.disconnect();
      note("drawn");
      return;
    }
    draw(next);
    idle(rest);
  }
  async function start() {
    note("opened");
    document.dispatchEvent(new Event("lexstack-open"));
    note("viewed");
    await runLibrary("plotly");
    scripts.forEach((script) => observer.observe(document.getElementById(script.dataset.figure)));
    draw(scripts[0]?.dataset.figure);
    note("plotted");
    idle(rest);
  }

  // Says when, in ms from the beginning of the navigation.
  function note(what) {
    document.documentElement.dataset[what] = performance.now().toFixed(0);
  }

  addEventListener("load", () => requestAnimationFrame(() => setTimeout(start)));
  return { cursor, draw, linked };
})();
