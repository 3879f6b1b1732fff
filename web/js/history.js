// What a drive did, one bin per decision: least and largest value of each curve.

export class History {
  constructor(core, bins) {
    this.core = core;
    this.bins = bins;
    const rings = () =>
      Object.fromEntries(core.curveNames.map((name) => [name, new Float32Array(bins)]));
    this.low = rings();
    this.high = rings();
    this.clear();
  }

  clear() {
    this.count = 0; // bins ever written; bin b is at b modulo bins
  }

  // Takes in the rows of one decision.
  add(rows) {
    if (rows === 0) return;
    const { curveNames, least, most } = this.core;
    this.core.findRange(rows);
    const slot = this.count % this.bins;
    for (let c = 0; c < curveNames.length; c++) {
      this.low[curveNames[c]][slot] = least[c];
      this.high[curveNames[c]][slot] = most[c];
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
