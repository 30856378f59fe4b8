// The trajectory: arrays by their path in the file, and what lies between their rows.

const TYPES = { float64: Float64Array, float32: Float32Array, int32: Int32Array };

export function decoded({ dtype, shape, base64 }) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  return { values: new TYPES[dtype](bytes.buffer), width: shape.slice(1).reduce((a, b) => a * b, 1) };
}

export class Motion {
  constructor(arrays) {
    this.arrays = Object.fromEntries(Object.entries(arrays).map(([path, array]) => [path, decoded(array)]));
    this.times = this.arrays.time.values;
    this.duration = this.times.at(-1);
    this.seek(0);
  }

  // From now on, values are those at time t: between `row` and the next one, `fraction` of the interval later.
  seek(t) {
    this.time = Math.min(Math.max(t, 0), this.duration);
    this.row = Math.max(0, Math.min(this.rowAt(this.time), this.times.length - 2));
    const [from, to] = [this.times[this.row], this.times[this.row + 1] ?? Infinity];
    this.interval = to - from;
    this.fraction = (this.time - from) / this.interval;
  }

  // The last row at or before t.
  rowAt(t) {
    let [low, high] = [0, this.times.length];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= t) low = middle;
      else high = middle;
    }
    return low;
  }

  // All values of one component, row by row.
  column(path, component = 0) {
    const { values, width } = this.arrays[path];
    return Array.from({ length: values.length / width }, (_, row) => values[row * width + component]);
  }

  // The two values around the present time.
  around(path, component) {
    const { values, width } = this.arrays[path];
    const first = values[this.row * width + component];
    return [first, values[(this.row + 1) * width + component] ?? first];
  }

  // What does not lie between rows, a roller's number for one.
  held(path, component = 0) {
    return this.around(path, component)[this.fraction < 1 ? 0 : 1];
  }

  has(path) {
    return path in this.arrays;
  }

  // That of the row which is nearer.
  nearest(path, component = 0) {
    return this.around(path, component)[this.fraction < 0.5 ? 0 : 1];
  }

  linear(path, component = 0) {
    const [first, second] = this.around(path, component);
    return this.fraction > 0 ? first + this.fraction * (second - first) : first;
  }

  // Cubic, by the rate of change at both rows.
  smooth(path, rate, component = 0) {
    const [first, second] = this.around(path, component);
    const [slope, nextSlope] = this.around(rate, component);
    const x = this.fraction;
    if (!(x > 0)) return first;
    const bend = this.interval * ((1 - x) * slope - x * nextSlope) + (2 * x - 1) * (second - first);
    return first + x * (second - first) + x * (1 - x) * bend;
  }
}
