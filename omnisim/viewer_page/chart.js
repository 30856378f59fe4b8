// One quantity over time, with a cursor in step; a click goes to that time.

import { uPlot } from "vendor";

const SERIES = ["#1f8ede", "#e07b1a", "#35a853", "#b05fd0", "#d2423c", "#14a3a8", "#a1887f", "#c0a000"];
const HEIGHT = 150;
const LEAST = 1e-9; // of speeds and forces that an axis shows: less is rounding

// What may be plotted: title with unit, and the columns by name.
function quantities(motion, wheels) {
  const sizes = (...columns) => columns[0].map((_, row) => Math.hypot(...columns.map((column) => column[row])));
  const pair = (path) => sizes(motion.column(path, 0), motion.column(path, 1));
  const each = (make) => Object.fromEntries(wheels.map(({ name }) => [name, make(`wheels/${name}`)]));
  return {
    "speed, m/s": { speed: pair("body/velocity") },
    "yaw rate, rad/s": { "yaw rate": motion.column("body/yaw_rate") },
    "slip, m/s": each((path) => pair(`${path}/slip_velocity`)),
    "normal force, N": each((path) => motion.column(`${path}/normal_force`)),
    "friction force, N": each((path) => pair(`${path}/friction_force`)),
    "energy balance, J": { balance: motion.column("energy/balance") },
  };
}

// Limits of an axis for these values: rounding does not fill it.
function spread(low, high, least) {
  return high - low < least ? [low - least, high + least] : uPlot.rangeNum(low, high, 0.1, true);
}

export class Chart {
  constructor(element, select, motion, wheels, seek) {
    Object.assign(this, { element, select, motion, seek, quantities: quantities(motion, wheels) });
    select.append(...Object.keys(this.quantities).map((name) => new Option(name)));
    select.addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.plot?.setSize({ width: element.clientWidth, height: this.height })).observe(element);
  }

  get height() {
    return HEIGHT - 28; // the legend takes the rest
  }

  recolour(colour) {
    this.colours = { text: colour("faint"), grid: colour("border") };
    this.draw();
  }

  draw() {
    const columns = this.quantities[this.select.value];
    const axis = { stroke: this.colours.text, grid: { stroke: this.colours.grid, width: 0.5 }, ticks: { show: false } };
    const number = (_, value) => (value == null ? "" : Number(value.toPrecision(4)).toString());
    const short = (_, ticks) => ticks.map((tick) => Number(tick.toPrecision(6)).toString());
    const least = this.select.value.startsWith("energy") ? 0 : LEAST;
    this.plot?.destroy();
    this.plot = new uPlot(
      {
        width: this.element.clientWidth,
        height: this.height,
        scales: { x: { time: false }, y: { range: (_, low, high) => spread(low, high, least) } },
        axes: [
          { ...axis, size: 26, values: short },
          { ...axis, size: 58, values: short },
        ],
        series: [
          { label: "t, s", value: number },
          ...Object.keys(columns).map((label, i) => ({
            label,
            stroke: SERIES[i % SERIES.length],
            width: 1.5,
            points: { show: false },
            value: number,
          })),
        ],
        hooks: { ready: [(plot) => this.update(plot)] },
        cursor: {
          y: false,
          drag: { x: false, y: false },
          bind: { mousemove: none, mouseenter: none, mouseleave: none },
        },
      },
      [Array.from(this.motion.times), ...Object.values(columns)],
      this.element,
    );
    const go = (event) => event.buttons && this.seek(this.plot.posToVal(event.offsetX, "x"));
    this.plot.over.addEventListener("pointerdown", go);
    this.plot.over.addEventListener("pointermove", go);
  }

  update(plot = this.plot) {
    plot.setCursor({ left: plot.valToPos(this.motion.time, "x"), top: 0 });
  }
}

const none = () => null; // the cursor is where the time is, not the mouse
