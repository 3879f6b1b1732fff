// Round numbers for axes and sliders.

// Least of 1, 2, 5 times a power of ten that is not below x.
export function roundUp(x) {
  if (!(x > 0) || !isFinite(x)) return 1;
  const power = 10 ** Math.floor(Math.log10(x) + 1e-9);
  return power * [1, 2, 5, 10].find((m) => m * power >= x * 0.999999);
}

// As few digits as steps of that size need.
export function digits(step) {
  return Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
}

// Ticks from low to high, at most about `most`.
export function ticks(low, high, most) {
  let step = roundUp((high - low) / most);
  if (Math.floor(high / step) - Math.ceil(low / step) < 1) step /= 2; // at least two of them
  const out = [];
  for (let j = Math.ceil(low / step - 1e-9); j * step <= high + 1e-9 * step; j++) out.push(j * step);
  return { values: out, digits: digits(step) };
}

// A range of an axis that follows a signal: widens at once, narrows when half of it is empty.
export class Range {
  constructor(low, high) {
    this.low = low;
    this.high = high;
    this.least = high - low;
  }

  follow(low, high) {
    if (!(low <= high)) return;
    const fits = low >= this.low && high <= this.high;
    const wide = (high - low) * 2.6 < this.high - this.low && this.high - this.low > this.least * 1.01;
    if (fits && !wide) return;
    const size = Math.max(high - low, this.least);
    const step = roundUp(size / 8);
    const middle = (low + high) / 2;
    this.low = Math.floor((middle - size / 2) / step - 0.2) * step;
    this.high = Math.ceil((middle + size / 2) / step + 0.2) * step;
  }
}
