// How finely to draw while something moves: as finely as comes out smooth on this computer, told by its frame times.

// Finest first: whether edges are smoothed, the part of the screen's pixels drawn along each side, and the time between
// changes of slider, chart and numbers, s.
const LEVELS = [
  { antialias: true, part: 1, pause: 0 },
  { antialias: false, part: 1, pause: 0.1 },
  { antialias: false, part: 0.7, pause: 0.1 },
  { antialias: false, part: 0.5, pause: 0.2 },
];
const STEP = 1.5; // by which the work shrinks from one to the next, about
export const FINEST = LEVELS[0];
const SLOW = 1 / 29; // s, a frame that is not smooth; screens of 30 frames/s are
const FAST = 1 / 45; // s, a frame that leaves time for more
const JUDGED = { frames: 4, time: 0.4 }; // at least, s

export class Quality {
  constructor() {
    Object.assign(this, { at: 0, patience: 2, smooth: 0, times: [] });
  }

  get level() {
    return LEVELS[this.at];
  }

  // The time from one frame to the next, s. A median is judged, so that a hiccup changes nothing.
  passed(time) {
    this.times.push(time);
    const [count, total] = [this.times.length, this.times.reduce((sum, one) => sum + one, 0)];
    if (count < JUDGED.frames || total < JUDGED.time) return;
    const median = this.times.sort((a, b) => a - b)[count >> 1];
    this.times = [];
    this.smooth = median < FAST ? this.smooth + total : 0;
    if (median > SLOW) this.lower(Math.ceil(Math.log(median / SLOW) / Math.log(STEP)));
    else if (this.smooth > this.patience) this.raise();
  }

  // A finer level is tried again, but later each time: what was too much once may well be too much always.
  lower(by) {
    const before = this.at;
    this.at = Math.min(before + by, LEVELS.length - 1);
    if (this.at > before) this.patience *= 2;
  }

  raise() {
    this.at = Math.max(this.at - 1, 0);
    this.smooth = 0;
  }
}
