"use strict";
// Plays a recorded run in the 3-D view: a slider over its time, tied to the time of the plots.
document.addEventListener("lexstack-open", () => {
  const source = document.getElementById("view3d-data");
  if (!source) return;
  const { scene, frames, targets, paths, box, radii, marks, stacks } =
    JSON.parse(source.textContent);
  const view = View3d.open(document.getElementById("view3d"), scene);
  if (!view) return;
  const numbers = (text) => new Float32Array(decoded(text));
  const [time, q, obstacles, alpha] = ["time", "q", "obstacles", "alpha"]
    .map((name) => numbers(frames[name]));
  const [since, ee] = [numbers(targets.from), numbers(targets.poses)];
  const size = { q: q.length / time.length, ee: ee.length / since.length };
  const slider = document.getElementById("view3d-time");
  const button = document.getElementById("view3d-play");
  const speed = document.getElementById("view3d-speed");
  const label = document.getElementById("view3d-label");
  const [begin, end] = [time[0], time[time.length - 1]];
  let now = begin;
  let playing = false;

  // The place of the last of some ascending times that is not after a time; 0 where all are.
  function last(times, seconds) {
    let [low, high] = [0, times.length];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= seconds + 1e-5) low = middle; else high = middle;
    }
    return low;
  }

  // The frames between which a time lies, and how far on the way it is.
  function frameAt(seconds) {
    const low = last(time, seconds);
    const high = Math.min(low + 1, time.length - 1);
    if (high === low) return [low, high, 0];
    return [low, high, Math.min(1, Math.max(0, (seconds - time[low]) / (time[high] - time[low])))];
  }

  function between(data, width, [low, high, part]) {
    const row = new Float32Array(width);
    for (let i = 0; i < width; i++) {
      row[i] = (1 - part) * data[low * width + i] + part * data[high * width + i];
    }
    return row;
  }

  function show(seconds) {
    now = Math.min(end, Math.max(begin, seconds));
    const at = frameAt(now);
    const held = last(since, now) * size.ee; // targets jump: they are never between
    const poses = [];
    for (let i = held; i < held + size.ee; i += 7) poses.push(ee.subarray(i, i + 7));
    view.set({ q: between(q, size.q, at), ee: poses,
      obstacles: between(obstacles, 3 * radii.length, at) });
    slider.value = now;
    const stack = [...stacks].reverse().find((entry) => entry.start <= now + 1e-6) || stacks[0];
    const blend = Number.isFinite(alpha[at[0]]) ? `, α = ${alpha[at[0]].toFixed(2)}` : "";
    label.textContent = `${now.toFixed(2)} s  ${stack ? stack.name : ""}${blend}`;
    window.LexstackPlots?.cursor(now);
  }

  function play(on) {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (now >= end) now = begin;
    let before = performance.now();
    const step = (wall) => {
      if (!playing) return;
      show(now + (Math.max(0, wall - before) / 1000) * Number(speed.value));
      before = wall;
      if (now >= end) play(false); else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  view.obstacles(radii);
  for (const path of paths) view.path(new Float32Array(decoded(path.points)), path.color);
  view.look(box[0], box[1]);
  Object.assign(slider, { min: begin, max: end, step: "any" });
  for (const mark of marks) {
    const place = document.createElement("button");
    place.textContent = mark.label;
    place.title = `${mark.time.toFixed(2)} s: ${mark.name}`;
    place.addEventListener("click", () => show(mark.time));
    document.getElementById("view3d-marks").append(place);
  }
  slider.addEventListener("input", () => { play(false); show(Number(slider.value)); });
  button.addEventListener("click", () => play(!playing));
  document.addEventListener("lexstack-time", (event) => { play(false); show(event.detail); });
  show(begin);
  window.LexstackPlayer = { view, show, play };
});
