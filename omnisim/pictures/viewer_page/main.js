// The page: reads the data, shows the machine, lets time pass.

import { Arrows, KINDS } from "omnisim/arrows";
import { Chart } from "omnisim/chart";
import { Machine } from "omnisim/machine";
import { Motion } from "omnisim/motion";
import { FINEST, Quality } from "omnisim/quality";
import { Stage } from "omnisim/stage";
import { Timebar } from "omnisim/timebar";

const SETTLED = 150; // ms without a change, after which it is drawn at its finest

const element = (id) => document.getElementById(id);
const data = JSON.parse(element("data").textContent);
const motion = new Motion(data.motion);
const machine = new Machine(data.machine, motion);
const arrows = new Arrows(machine, motion);
machine.update();
const quality = new Quality();
let playing = false;
let asked, resting; // a frame to come, and the timer of one at rest
let before, told; // when the last frame was, if it led to this one, and when numbers last changed, ms
let largest; // of each kind of arrow
const stage = stageOrReason();
stage.scene.add(arrows.group);

const [chart, timebar] = [
  new Chart(
    { element: element("chart"), select: element("quantity"), note: element("pale") },
    motion,
    data.machine.wheels,
    seek,
  ),
  new Timebar(
    {
      slider: element("time"),
      canvas: element("marks"),
      tooltip: element("tooltip"),
      lanes: element("lanes"),
      axis: element("axis"),
    },
    data.events,
    motion.duration,
    seek,
  ),
];

function stageOrReason() {
  try {
    return new Stage(element("stage"), machine, motion, wake, data);
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
  move(t);
  tell();
}

function move(t) {
  motion.seek(t);
  machine.update();
  largest = arrows.update();
  wake();
}

function tell() {
  timebar.update(motion.time);
  chart.update();
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
  wake();
}

function pause() {
  playing = false;
  tell();
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

// A frame is drawn only where something has changed since the last one; a change while it is drawn asks for the next.
function wake() {
  asked ??= requestAnimationFrame(frame);
}

function frame(now) {
  asked = undefined;
  clearTimeout(resting);
  const passed = before ? (now - before) / 1000 : 0; // s
  if (passed) quality.passed(passed);
  if (playing) {
    move(motion.time + element("speed").value * passed);
    if (!(now - told < 1000 * quality.level.pause)) {
      tell();
      told = now;
    }
    if (motion.time >= motion.duration) pause();
  }
  stage.draw(quality.level);
  before = asked && now;
  if (!asked && quality.level !== FINEST) resting = setTimeout(() => stage.draw(FINEST), SETTLED);
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
  wake();
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
  inTheAir: (w) => machine.wheels[w].inTheAir,
  contactPoint: (w) => machine.wheels[w].contactPoint().toArray(),
  springLengths: () => machine.carriers.springs.map(({ left }) => left),
  carried: () => machine.carriers.moving.map(({ wheel, part }) => [wheel.wheel.name, part.matrix.toArray()]),
};
