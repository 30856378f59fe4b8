// The page: reads the data, shows the machine, lets time pass.

import { Arrows, KINDS } from "omnisim/arrows";
import { Chart } from "omnisim/chart";
import { Machine } from "omnisim/machine";
import { Motion } from "omnisim/motion";
import { Stage } from "omnisim/stage";
import { Timebar } from "omnisim/timebar";

const element = (id) => document.getElementById(id);
const data = JSON.parse(element("data").textContent);
const motion = new Motion(data.motion);
const machine = new Machine(data.machine, motion);
const arrows = new Arrows(machine, motion);
machine.update();
const stage = stageOrReason();
stage.scene.add(arrows.group);

const [chart, timebar] = [
  new Chart(element("chart"), element("quantity"), motion, data.machine.wheels, seek),
  new Timebar(
    { slider: element("time"), canvas: element("marks"), tooltip: element("tooltip"), legend: element("kinds") },
    data.events,
    motion.duration,
    seek,
  ),
];
let [playing, before] = [false, 0];

function stageOrReason() {
  try {
    return new Stage(element("stage"), machine, motion);
  } catch (error) {
    const problem = document.createElement("p");
    Object.assign(problem, {
      className: "problem",
      textContent: `This page draws with WebGL, which failed: ${error.message}`,
    });
    element("stage").append(problem);
    throw error;
  }
}

function seek(t) {
  motion.seek(t);
  machine.update();
  tell(arrows.update());
  timebar.update(motion.time);
  chart.update();
  stage.stale = true;
}

function tell(largest) {
  element("clock").textContent = `${motion.time.toFixed(3)} s of ${Number(motion.duration.toPrecision(6))} s`;
  const units = { normal: "N", friction: "N", slip: "m/s" };
  for (const kind of KINDS) {
    document.querySelector(`[value=${kind}] ~ output`).textContent = `${readable(largest[kind])} ${units[kind]}`;
  }
}

function readable(x) {
  if (x < 1e-6) return "0";
  return x < 1e-2 ? x.toExponential(1) : x.toPrecision(3);
}

function play() {
  if (motion.time >= motion.duration) seek(0);
  playing = true;
  showPlaying();
}

function pause() {
  playing = false;
  showPlaying();
}

function showPlaying() {
  element("play").textContent = playing ? "\u275A\u275A" : "\u25B6\uFE0E";
  element("play").setAttribute("aria-label", playing ? "Pause" : "Play");
}

// To the next row of the data, or the one before.
function step(by) {
  pause();
  const row = motion.rowAt(motion.time);
  const between = by < 0 && motion.time > motion.times[row];
  seek(motion.times[Math.min(Math.max(between ? row : row + by, 0), motion.times.length - 1)]);
}

function frame(now) {
  if (playing) {
    seek(motion.time + (element("speed").value * (now - before)) / 1000);
    if (motion.time >= motion.duration) pause();
  }
  before = now;
  stage.draw();
  requestAnimationFrame(frame);
}

const toggle = () => (playing ? pause() : play());
const follow = element("follow");
const KEYS = {
  " ": toggle,
  ArrowLeft: () => step(-1),
  ArrowRight: () => step(1),
  Home: () => seek(0),
  End: () => seek(motion.duration),
  f: () => follow.click(),
};

element("play").addEventListener("click", toggle);
element("back").addEventListener("click", () => step(-1));
element("next").addEventListener("click", () => step(1));
element("start").addEventListener("click", () => seek(0));
follow.addEventListener("change", () => (stage.follows = follow.checked));
addEventListener("keydown", (event) => {
  const ours =
    event.target.tagName === "SELECT" || (event.key === " " && ["BUTTON", "INPUT"].includes(event.target.tagName));
  if (ours || event.ctrlKey || event.altKey || event.metaKey || !KEYS[event.key]) return;
  event.preventDefault();
  KEYS[event.key]();
});
element("shown").addEventListener("change", ({ target }) => {
  if (KINDS.includes(target.value)) arrows.shown[target.checked ? "add" : "delete"](target.value);
  if (target.value === "trace") stage.trace.visible = target.checked;
  if (target.value === "chassis") machine.chassis.visible = target.checked;
  arrows.update();
  stage.stale = true;
});

function recolour() {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(`--${name}`).trim();
  for (const part of [stage, arrows, chart]) part.recolour(colour);
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolour);
element("shown").querySelector("[value=chassis]").parentElement.hidden = !machine.chassis;
element("scale").textContent = `grid ${Number(stage.cell.toPrecision(1))} m`;
element("status").textContent = data.status === "complete" ? "" : data.status;
element("status").hidden = data.status === "complete";
recolour();
seek(0);
requestAnimationFrame((now) => {
  before = now;
  frame(now);
});

window.omnisim = {
  get time() {
    return motion.time;
  },
  get duration() {
    return motion.duration;
  },
  get playing() {
    return playing;
  },
  seek,
  play,
  pause,
  rollerPosition: (w, i) => machine.rollerPosition(w, i).toArray(),
  contactPoint: (w) => machine.wheels[w].contactPoint().toArray(),
};
