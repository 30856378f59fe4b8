// The slider, and above it a mark for each event.

const COLOURS = {
  exchange: "#8b98a5",
  stick: "#2e9e44",
  slip: "#e5a50a",
  lift_off: "#1f8ede",
  touch_down: "#3f51b5",
  share_begin: "#b05fd0",
  share_end: "#d991ee",
  stop: "#d2423c",
};
const NEAR = 6; // px from a mark to its tooltip
const THUMB = 8; // px that the slider's own track keeps at its ends

export class Timebar {
  constructor({ slider, canvas, tooltip, legend }, events, duration, seek) {
    Object.assign(this, { slider, canvas, tooltip, events, duration });
    slider.max = duration;
    slider.addEventListener("input", () => seek(slider.valueAsNumber));
    canvas.addEventListener("pointermove", (event) => this.tell(this.nearest(event.offsetX)));
    canvas.addEventListener("pointerleave", () => this.tell(-1));
    canvas.addEventListener("click", (event) => {
      const found = this.nearest(event.offsetX);
      seek(found < 0 ? this.timeAt(event.offsetX) : events.time[found]);
    });
    legend.append(...this.counts());
    new ResizeObserver(() => this.draw()).observe(canvas);
    this.draw();
  }

  counts() {
    const { kinds, kind } = this.events;
    return kinds
      .map((name, k) => [name, kind.filter((one) => one === k).length])
      .filter(([, n]) => n)
      .map(([name, n]) => {
        const [entry, swatch] = [document.createElement("span"), document.createElement("i")];
        swatch.style.background = COLOURS[name];
        entry.append(swatch, `${n} ${words(name)}`);
        return entry;
      });
  }

  place(t) {
    return THUMB + (this.canvas.clientWidth - 2 * THUMB) * (this.duration > 0 ? t / this.duration : 0);
  }

  timeAt(x) {
    return (this.duration * (x - THUMB)) / (this.canvas.clientWidth - 2 * THUMB);
  }

  // The event next to x, px; exchanges, which are many, after all others. -1 if there is none.
  nearest(x) {
    const { time, kind } = this.events;
    const far = (i) => Math.abs(this.place(time[i]) - x) + (kind[i] === 0 ? 0.5 * NEAR : 0);
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
    this.tooltip.style.left = `${Math.min(Math.max(this.place(time[i]), half), this.canvas.clientWidth - half)}px`;
  }

  draw() {
    const { canvas, events } = this;
    const scale = devicePixelRatio;
    Object.assign(canvas, { width: canvas.clientWidth * scale, height: canvas.clientHeight * scale });
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    const order = events.time.map((_, i) => i);
    order.sort((a, b) => (events.kind[a] > 0) - (events.kind[b] > 0)); // exchanges below
    for (const i of order) {
      const tall = events.kind[i] > 0;
      pen.fillStyle = COLOURS[events.kinds[events.kind[i]]];
      pen.fillRect(this.place(events.time[i]) - 0.75, tall ? 0 : 5, 1.5, canvas.clientHeight);
    }
  }

  update(t) {
    this.slider.value = t;
    this.slider.setAttribute("aria-valuetext", `${t.toFixed(3)} s`);
  }
}

function words(kind) {
  return kind.replace("_", " ");
}
