// What a drive did, one bin per decision: least and largest value of each curve.

const DEGREES = 180 / Math.PI;

// Curves: from a row of a trace to a number. c: columns by name; m: motor; w: r/min per rad/s.
export const CURVES = {
  speed_ref: (r, at, c, w) => r[at + c.omega_m_ref] * w,
  speed: (r, at, c, w) => r[at + c.omega_m] * w,
  load: (r, at, c) => r[at + c.tau_load],
  torque: (r, at, c) => r[at + c.tau],
  err: (r, at, c) => r[at + c.theta_e_err] * DEGREES,
  err_hfi: (r, at, c) => r[at + c.theta_e_err_hfi] * DEGREES,
  err_observer: (r, at, c) => r[at + c.theta_e_err_smo] * DEGREES,
  k_s: (r, at, c) => r[at + c.k_s],
  voltage: (r, at, c) => Math.hypot(r[at + c.u_a], r[at + c.u_b]),
  limit: (r, at, c) => r[at + c.u_dc] / Math.sqrt(3),
  current: (r, at, c) => Math.hypot(r[at + c.i_d], r[at + c.i_q]),
};

const CURVE_NAMES = Object.keys(CURVES);

export class History {
  constructor(core, bins) {
    this.core = core;
    this.bins = bins;
    this.columns = Object.fromEntries(core.layout.trace.map((name, j) => [name, j]));
    this.low = Object.fromEntries(CURVE_NAMES.map((name) => [name, new Float32Array(bins)]));
    this.high = Object.fromEntries(CURVE_NAMES.map((name) => [name, new Float32Array(bins)]));
    this.clear();
  }

  clear() {
    this.count = 0; // bins ever written; bin b is at b modulo bins
  }

  // Takes in the rows of one decision.
  add(rows) {
    if (rows === 0) return;
    const { rows: r, rowLength } = this.core;
    const slot = this.count % this.bins;
    const w = 1 / this.core.layout.rpm;
    for (const name of CURVE_NAMES) {
      const curve = CURVES[name];
      let low = Infinity;
      let high = -Infinity;
      for (let j = 0; j < rows; j++) {
        const x = curve(r, j * rowLength, this.columns, w);
        if (x < low) low = x;
        if (x > high) high = x;
      }
      this.low[name][slot] = low;
      this.high[name][slot] = high;
    }
    this.count += 1;
  }

  // First bin that is still known.
  get first() {
    return Math.max(0, this.count - this.bins);
  }

  // Mean of the least and largest value over the last bins.
  latest(name, over = 20) {
    const from = Math.max(this.first, this.count - over);
    if (from >= this.count) return NaN;
    let sum = 0;
    for (let b = from; b < this.count; b++) {
      sum += this.low[name][b % this.bins] + this.high[name][b % this.bins];
    }
    return sum / (2 * (this.count - from));
  }

  // Largest magnitude over the last bins.
  largest(name, over) {
    let most = 0;
    for (let b = Math.max(this.first, this.count - over); b < this.count; b++) {
      const slot = b % this.bins;
      most = Math.max(most, -this.low[name][slot], this.high[name][slot]);
    }
    return most;
  }
}
