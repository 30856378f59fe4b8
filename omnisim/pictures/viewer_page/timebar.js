// The slider, below it the time, above it the events: a lane for each kind that there is, named at its left.

const COLOURS = {
  exchange: "#8b98a5",
  stick: "#2e9e44",
  slip: "#e5a50a",
  lift_off: "#1f8ede",
  touch_down: "#3f51b5",
  share_begin: "#b05fd0",
  share_end: "#d991ee",
  contact_begin: "#7a93ad",
  contact_end: "#a9b8c6",
  stop: "#d2423c",
};
const NEAR = 6; // px from a mark to its tooltip
const LANE = 12; // px, the height of a lane; its marks leave a gap
const GAP = 2;
const APART = 80; // px between two numbers of the time axis, at least
export const THUMB = 8; // px that the slider's own track keeps at its ends

// Round times from 0 to a duration, s, for an axis of so many pixels.
export function ticks(duration, pixels) {
  const least = (duration * APART) / Math.max(pixels, 1);
  if (!(least > 0) || !isFinite(least)) return [0];
  const decade = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((digit) => digit * decade).find((one) => one >= least);
  const count = Math.floor(duration / step + 1e-9);
  return Array.from({ length: count + 1 }, (_, i) => Number((i * step).toPrecision(12)));
}

export class Timebar {
  constructor({ slider, canvas, tooltip, lanes, axis }, events, duration, seek) {
    Object.assign(this, { slider, canvas, tooltip, axis, events, duration });
    slider.max = duration;
    slider.addEventListener("input", () => seek(slider.valueAsNumber));
    canvas.addEventListener("pointermove", (event) => this.tell(this.nearest(event.offsetX, event.offsetY)));
    canvas.addEventListener("pointerleave", () => this.tell(-1));
    canvas.addEventListener("click", (event) => {
      const found = this.nearest(event.offsetX, event.offsetY);
      seek(found < 0 ? this.timeAt(event.offsetX) : events.time[found]);
    });
    const counts = events.kinds.map((_, k) => events.kind.filter((one) => one === k).length);
    this.lanes = counts.flatMap((count, k) => (count ? [k] : []));
    lanes.append(...this.lanes.map((k) => named(events.kinds[k], counts[k])));
    canvas.style.height = `${LANE * this.lanes.length}px`;
    new ResizeObserver(() => this.draw()).observe(slider);
    this.draw();
  }

  place(t) {
    return THUMB + (this.slider.clientWidth - 2 * THUMB) * (this.duration > 0 ? t / this.duration : 0);
  }

  timeAt(x) {
    return (this.duration * (x - THUMB)) / (this.slider.clientWidth - 2 * THUMB);
  }

  // The event next to x, px, in the lane at y; -1 if there is none.
  nearest(x, y) {
    const { time, kind } = this.events;
    const lane = this.lanes[Math.floor(y / LANE)];
    const far = (i) => (kind[i] === lane ? Math.abs(this.place(time[i]) - x) : Infinity);
    return time.reduce((best, _, i) => (far(i) < (best < 0 ? NEAR : far(best)) ? i : best), -1);
  }

  tell(i) {
    this.tooltip.hidden = i < 0;
    if (i < 0) return;
    const { kinds, kind, time, wheel, roller_from: from, roller_to: to } = this.events;
    const whose = wheel[i] && ` of ${wheel[i]}`;
    const rollers = from[i] >= 0 && to[i] >= 0 ? `, roller ${from[i]} to ${to[i]}` : "";
    this.tooltip.textContent = `${time[i].toFixed(4)} s: ${words(kinds[kind[i]])}${whose}${rollers}`;
    const half = this.tooltip.clientWidth / 2;
    const place = Math.min(Math.max(this.place(time[i]), half), this.canvas.clientWidth - half);
    this.tooltip.style.left = `${this.canvas.offsetLeft + place}px`;
  }

  draw() {
    const { canvas, events } = this;
    const scale = devicePixelRatio;
    Object.assign(canvas, { width: canvas.clientWidth * scale, height: canvas.clientHeight * scale });
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    events.time.forEach((time, i) => {
      pen.fillStyle = COLOURS[events.kinds[events.kind[i]]];
      pen.fillRect(this.place(time) - 0.75, LANE * this.lanes.indexOf(events.kind[i]), 1.5, LANE - GAP);
    });
    this.axis.replaceChildren(
      ...ticks(this.duration, this.slider.clientWidth - 2 * THUMB).map((time) => {
        const label = document.createElement("span");
        label.textContent = time;
        label.style.left = `${this.place(time)}px`;
        return label;
      }),
    );
  }

  update(t) {
    this.slider.value = t;
    this.slider.setAttribute("aria-valuetext", `${t.toFixed(3)} s`);
  }
}

// The name of a lane with how many events are in it.
function named(kind, count) {
  const [entry, swatch] = [document.createElement("span"), document.createElement("i")];
  swatch.style.background = COLOURS[kind];
  entry.append(swatch, `${count} ${words(kind)}`);
  return entry;
}

function words(kind) {
  return kind.replace("_", " ");
}
