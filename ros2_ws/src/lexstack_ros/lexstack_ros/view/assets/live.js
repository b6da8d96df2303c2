"use strict";
// Shows what the run tells, twenty times a second, and sends what the buttons ask for.
(() => {
  const setup = JSON.parse(document.getElementById("setup").textContent);
  const at = (id) => document.getElementById(id);
  const ROBOTS = ["#D55E00", "#0072B2"]; // robot A is orange, as in the view
  const COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];
  const DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];
  const BANDS = { braking: "rgba(213, 94, 0, 0.20)", holding: "rgba(230, 159, 0, 0.22)" };
  const WINDOW = 20; // s
  const LEAST = 1e-9; // a logarithm has no zero
  const history = []; // of the window
  let last; // news
  let begun; // tick and wall time of the first news, for the rate
  let shown; // what the view shows, as text
  let view;

  // plotly.js takes some tags in a text for its own: no name shall have any.
  function plotText(text) {
    return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
  }

  function options(select, values) {
    select.append(...values.map((value) => new Option(value, value)));
  }

  function show(news) {
    const pose = JSON.stringify([news.q, news.ee, news.obstacles]);
    if (pose !== shown) view?.set(news); // robots at rest cost nothing
    shown = pose;
    last = news;
    at("time").textContent = `${news.time.toFixed(2)} s`;
    at("tick").textContent = news.tick;
    at("plant").textContent = news.plant;
    at("plant").className = BANDS[news.plant] ? "bad" : "";
    at("stack").textContent = news.stack;
    at("phase").textContent = news.phase;
    at("alpha").value = news.alpha;
    at("alpha-text").textContent = news.alpha.toFixed(3);
    at("reason").textContent = news.reason;
    const wall = performance.now() / 1000;
    if (!begun || news.tick < begun.tick || wall - begun.wall > 3) begun = { tick: news.tick, wall };
    if (wall - begun.wall > 0.5) {
      at("rate").textContent = ((news.tick - begun.tick) / (wall - begun.wall)).toFixed(0);
    }
    if (history.length && news.time < history[history.length - 1].time) history.length = 0;
    if (!history.length || news.time > history[history.length - 1].time) history.push(news);
    while (history.length && history[0].time < news.time - WINDOW) history.shift();
  }

  function traces() {
    const x = history.map((news) => news.time);
    const line = (name, y, i, row, unit, colors = COLORS) => ({
      type: "scatter", mode: "lines", name, x, y, xaxis: "x", yaxis: `y${row}`,
      line: { color: colors[i % colors.length], dash: DASHES[i % 6], width: 1.6 },
      hovertemplate: `%{y:.4g} ${unit}`,
    });
    const most = Math.max(0, ...history.map((news) => news.levels.length));
    const level = (k) => history.map((news) => (k < news.levels.length
      ? Math.max(news.levels[k], LEAST) : null));
    const names = [...new Set(history.flatMap((news) => Object.keys(news.solve)))];
    return [
      ...Array.from({ length: most }, (_, k) => line(`level ${k + 1}`, level(k), k, "",
        "m/s, rad/s")),
      ...names.map((name, i) => line(`solve time ${plotText(name)}`,
        history.map((news) => news.solve[name] ?? null), i, 2, "ms", ROBOTS)),
      line("α", history.map((news) => news.alpha), 3, 3, ""),
    ];
  }

  // The times in which the plant braked or held the last command.
  function bands() {
    const found = [];
    history.forEach((news, i) => {
      if (!BANDS[news.plant]) return;
      const begin = i ? history[i - 1].time : news.time;
      const last = found[found.length - 1];
      if (last && last.name === news.plant && last.x1 === begin) last.x1 = news.time;
      else found.push({ type: "rect", name: news.plant, xref: "x", yref: "paper", x0: begin,
        x1: news.time, y0: 0, y1: 1, fillcolor: BANDS[news.plant], line: { width: 0 },
        layer: "below" });
    });
    return found;
  }

  const axis = (title, domain, more) => ({ title: { text: title }, domain, gridcolor: "#E3E7EC",
    zeroline: false, showline: true, linecolor: "#B8C1CB", ...more });
  const layout = {
    height: 460, margin: { l: 70, r: 46, t: 40, b: 44 }, hovermode: "x", uirevision: "live",
    font: { family: "system-ui, sans-serif", size: 12 }, legend: { orientation: "h", y: 1.12 },
    modebar: { orientation: "v" },
    xaxis: axis("simulated time [s]", [0, 1], { anchor: "y3" }),
    yaxis: axis("residual [m/s, rad/s]", [0.64, 1], { type: "log", exponentformat: "power" }),
    yaxis2: axis("solve time [ms]", [0.3, 0.58], { rangemode: "tozero" }),
    yaxis3: axis("α [-]", [0, 0.22], { range: [-0.05, 1.05] }),
  };

  function draw() {
    if (document.hidden) return;
    layout.shapes = bands();
    Plotly.react("strips", traces(), layout, { displaylogo: false });
  }

  async function order(content) {
    const answer = at("answer");
    answer.className = "";
    answer.textContent = "…";
    try {
      const response = await fetch("/order", {
        method: "POST", headers: { "Content-Type": "application/json" },
        body: JSON.stringify(content),
      });
      const { ok, message } = await response.json();
      answer.className = ok ? "" : "bad";
      answer.textContent = message;
    } catch (error) {
      answer.className = "bad";
      answer.textContent = `not sent: ${error.message}`;
    }
  }

  const numbers = (selector) => [...document.querySelectorAll(selector)].map((i) => Number(i.value));

  function present() {
    if (!last) return;
    const robot = setup.robots.indexOf(at("target-robot").value);
    const values = at("target-kind").value === "ee" ? last.ee[robot].slice(0, 3) : last.base[robot];
    document.querySelectorAll(".target").forEach((input, i) => { input.value = values[i].toFixed(3); });
  }

  function connect() {
    const events = new EventSource("/events");
    events.onopen = () => { at("connection").textContent = "connected"; };
    events.onerror = () => { at("connection").textContent = "the run has ended or is not reached"; };
    events.onmessage = (event) => {
      const isFirst = !last;
      show(JSON.parse(event.data));
      if (isFirst) present();
      at("connection").textContent = "connected";
    };
  }

  async function begin() {
    view = View3d.open(at("view3d"), setup.scene);
    view?.obstacles(setup.radii);
    view?.look([-1, -1.2, 0], [3, 1.2, 1.4]);
    await runLibrary("plotly");
    connect();
    draw();
    setInterval(draw, 1000);
    window.LexstackLive = { view, news: () => last, order };
  }

  options(at("to"), setup.stacks);
  options(at("target-robot"), setup.robots);
  options(at("push-robot"), setup.robots);
  at("switch").addEventListener("click", () => order({ do: "switch", stack: at("to").value,
    duration: Number(at("duration").value) }));
  at("cancel").addEventListener("click", () => order({ do: "cancel" }));
  at("here").addEventListener("click", present);
  at("target").addEventListener("click", () => order({ do: "target",
    robot: at("target-robot").value, kind: at("target-kind").value, values: numbers(".target") }));
  at("push").addEventListener("click", () => order({ do: "push", robot: at("push-robot").value,
    link: at("push-link").value, force: numbers(".force"),
    duration: Number(at("push-time").value) }));
  for (const id of ["target-robot", "target-kind"]) at(id).addEventListener("change", present);
  addEventListener("load", () => requestAnimationFrame(() => setTimeout(begin)));
})();
