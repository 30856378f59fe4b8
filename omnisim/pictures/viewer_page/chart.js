// One quantity over time, with a cursor in step; a click goes to that time. Its time runs as that of the slider below.

import { uPlot } from "vendor";
import { quantities } from "omnisim/quantities";
import { THUMB, ticks } from "omnisim/timebar";

const SERIES = ["#1f8ede", "#e07b1a", "#35a853", "#b05fd0", "#d2423c", "#14a3a8", "#a1887f", "#c0a000"];
const HEIGHT = 122; // px, without the legend
const GUTTER = 108; // px left of the time 0, as in style.css
const LEAST = 1e-9; // of speeds and forces that an axis shows: less is rounding

// Limits of an axis for these values: rounding does not fill it.
function spread(low, high, least) {
  return high - low < least ? [low - least, high + least] : uPlot.rangeNum(low, high, 0.1, true);
}

export class Chart {
  constructor({ element, select, note }, motion, wheels, seek) {
    Object.assign(this, { element, select, note, motion, seek, quantities: quantities(motion, wheels) });
    select.append(...Object.keys(this.quantities).map((name) => new Option(name)));
    select.addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.plot?.setSize({ width: element.clientWidth, height: HEIGHT })).observe(element);
  }

  recolour(colour) {
    this.colours = { text: colour("faint"), grid: colour("border") };
    this.draw();
  }

  draw() {
    const { series, bands, columns } = drawn(this.quantities[this.select.value]);
    const { duration } = this.motion;
    const axis = { stroke: this.colours.text, grid: { stroke: this.colours.grid, width: 0.5 }, ticks: { show: false } };
    const least = this.select.value.startsWith("energy") ? 0 : LEAST;
    const within = (plot) => ticks(duration, plot.bbox.width / devicePixelRatio);
    this.note.hidden = !bands.length;
    this.plot?.destroy();
    this.plot = new uPlot(
      {
        width: this.element.clientWidth,
        height: HEIGHT,
        padding: [8, THUMB, 6, 0],
        scales: {
          x: { time: false, range: () => [0, duration || 1] },
          y: { range: (_, low, high) => spread(low, high, least) },
        },
        axes: [
          { ...axis, size: 0, splits: within, values: (_, times) => times.map(() => "") },
          { ...axis, size: GUTTER, space: 22, values: (_, numbers) => numbers.map((one) => Number(one.toPrecision(6)).toString()) },
        ],
        series: [{ label: "t, s", value: (_, time) => short(time) }, ...series],
        bands,
        hooks: { ready: [(plot) => this.update(plot)] },
        cursor: {
          y: false,
          drag: { x: false, y: false },
          bind: { mousemove: none, mouseenter: none, mouseleave: none },
        },
      },
      [Array.from(this.motion.times), ...columns],
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

// Series, bands and columns of uPlot for some curves: targets dashed, extremes as a pale band. Both stand in no legend:
// a curve has its target's value beside its own.
function drawn(curves) {
  const [series, bands, columns] = [[], [], []];
  const add = (values, how) => {
    series.push({ points: { show: false }, ...how });
    return columns.push(values);
  };
  curves.forEach(({ label, values, target, low, high }, i) => {
    const stroke = SERIES[i % SERIES.length];
    const hidden = { label, class: "beside", points: { show: false, size: 0 } };
    if (high) {
      const edge = { ...hidden, width: 0, paths: uPlot.paths.stepped({ align: -1 }) };
      bands.push({ series: [add(high, edge), add(low, edge)], fill: `${stroke}40` });
    }
    if (target) add(target, { ...hidden, stroke, width: 1.2, dash: [5, 4] });
    const value = (_, one, __, row) => short(one) + (target && one != null ? ` (target ${short(target[row])})` : "");
    add(values, { label, stroke, width: 1.5, value });
  });
  return { series, bands, columns };
}

function short(value) {
  return value == null ? "" : Number(value.toPrecision(4)).toString();
}

const none = () => null; // the cursor is where the time is, not the mouse
