// One moving plot on a canvas: bands from the least to the largest value of every pixel.

import { Range, ticks } from "./axis.js";

export const LEFT = 52; // pixels left of the axis
const RIGHT = 8;
const TOP = 6;

// What a curve shows: a reference is the same for all drives, and one may have stopped.
export function source(curve, histories) {
  const longest = histories[1].count > histories[0].count ? histories[1] : histories[0];
  return curve.common ? longest : histories[curve.side];
}

export class Plot {
  // what: title, unit, curves [{ name, side, colour, text }], range [low, high] at the beginning,
  // fixed: the range does not follow.
  constructor(canvas, what) {
    this.canvas = canvas;
    this.what = what;
    this.hidden = new Set();
    this.range = new Range(...what.range);
  }

  // Fits the canvas to its place on the screen.
  resize() {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: w, clientHeight: h } = this.canvas;
    if (this.canvas.width !== Math.round(w * ratio)) this.canvas.width = Math.round(w * ratio);
    if (this.canvas.height !== Math.round(h * ratio)) this.canvas.height = Math.round(h * ratio);
    this.width = w;
    this.height = h;
    this.ratio = ratio;
  }

  // span: decisions across the plot; end: the one at its right edge; histories: of each drive;
  // marks: [{ decision, side }]; look: colours; cursor: decision under the pointer or null.
  draw({ span, end, histories, decisionTime, marks, look, cursor, last, sides }) {
    this.resize();
    const g = this.canvas.getContext("2d");
    g.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    g.clearRect(0, 0, this.width, this.height);
    const plotWidth = this.width - LEFT - RIGHT;
    const bottom = last ? 20 : 6;
    const plotHeight = this.height - TOP - bottom;
    if (plotWidth < 20 || plotHeight < 20) return;
    const start = end - span;
    const shown = this.what.curves.filter((c) => c.side < sides && !this.hidden.has(c.text));
    const lines = shown.map((c) => this.bands(source(c, histories), c.name, start, span, plotWidth));
    if (!this.what.fixed) this.fit(lines);
    const { low, high } = this.range;
    const y = (v) => TOP + plotHeight * (1 - (Math.min(Math.max(v, low), high) - low) / (high - low));
    const x = (decision) => LEFT + (plotWidth * (decision - start)) / span;
    this.grid(g, look, y, plotWidth, plotHeight);
    this.times(g, look, x, start, end, decisionTime, plotHeight, last);
    for (const mark of marks) {
      if (mark.decision <= start || mark.side >= sides) continue;
      g.fillStyle = look[mark.side === 0 ? "a" : "b"];
      g.fillRect(x(mark.decision) - 0.75, TOP, 1.5, plotHeight);
    }
    shown.forEach((curve, j) => this.band(g, look[curve.colour], lines[j], y));
    shown.forEach((curve, j) => this.line(g, look[curve.colour], curve, lines[j], y));
    if (cursor !== null && cursor >= start) {
      g.fillStyle = look.text;
      g.fillRect(x(cursor) - 0.5, TOP, 1, plotHeight);
    }
  }

  // Pale, from the least to the largest value.
  band(g, colour, { low, high }, y) {
    g.fillStyle = colour;
    g.globalAlpha = 0.4;
    for (let px = 0; px < low.length; px++) {
      const top = y(high[px]);
      const height = y(low[px]) - top;
      if (height > 2) g.fillRect(LEFT + px, top, 1, height);
    }
    g.globalAlpha = 1;
  }

  // Through the middle of the band; dashed for the second drive, so that neither hides the other.
  line(g, colour, { side, thin }, { low, high }, y) {
    g.fillStyle = colour;
    const thick = thin ? 1 : 1.7;
    let before = NaN;
    for (let px = 0; px < low.length; px++) {
      const middle = (y(low[px]) + y(high[px])) / 2;
      const from = before === before ? before : middle; // joined, so that a steep curve has no gaps
      before = middle;
      const steep = Math.abs(from - middle) > 1;
      if (middle !== middle || (side === 1 && px % 10 >= 6 && !steep)) continue;
      const upper = Math.min(from, middle);
      g.fillRect(LEFT + px, upper - thick / 2, 1, Math.abs(from - middle) + thick);
    }
  }

  // Least and largest value of a curve under every pixel; NaN where nothing is known.
  bands(history, name, start, span, width) {
    const low = new Float32Array(Math.ceil(width)).fill(NaN);
    const high = new Float32Array(Math.ceil(width)).fill(NaN);
    const lows = history.low[name];
    const highs = history.high[name];
    const { bins, count, first } = history;
    for (let px = 0; px < width; px++) {
      const from = Math.max(first, Math.floor(start + (span * px) / width));
      const to = Math.min(count, Math.max(from + 1, Math.floor(start + (span * (px + 1)) / width)));
      let least = Infinity;
      let most = -Infinity;
      for (let b = from; b < to; b++) {
        const slot = b % bins;
        if (lows[slot] < least) least = lows[slot];
        if (highs[slot] > most) most = highs[slot];
      }
      if (least <= most && from >= start - 1) {
        low[px] = least;
        high[px] = most;
      }
    }
    return { low, high };
  }

  fit(lines) {
    let least = Infinity;
    let most = -Infinity;
    for (const { low, high } of lines) {
      for (let px = 0; px < low.length; px++) {
        if (low[px] < least) least = low[px];
        if (high[px] > most) most = high[px];
      }
    }
    const end = this.what.most ?? Infinity; // beyond it, curves run along the edge
    this.range.follow(Math.max(least, -end), Math.min(most, end));
  }

  grid(g, look, y, width, height) {
    const { low, high } = this.range;
    const marks = ticks(low, high, Math.max(2, height / 26));
    g.font = look.font;
    g.textAlign = "right";
    g.textBaseline = "middle";
    for (const value of marks.values) {
      g.fillStyle = value === 0 ? look.zero : look.grid;
      g.fillRect(LEFT, Math.round(y(value)) - 0.5, width, 1);
      g.fillStyle = look.muted;
      const text = value.toFixed(marks.digits).replace("-", "−");
      g.fillText(text, LEFT - 6, y(value));
    }
  }

  times(g, look, x, start, end, decisionTime, height, last) {
    const marks = ticks(start * decisionTime, end * decisionTime, 6);
    g.textAlign = "center";
    g.textBaseline = "top";
    for (const value of marks.values) {
      const at = x(value / decisionTime);
      if (value < -1e-9 || at < LEFT) continue;
      g.fillStyle = look.grid;
      g.fillRect(Math.round(at) - 0.5, TOP, 1, height);
      if (last && at < this.width - 14) {
        g.fillStyle = look.muted;
        g.fillText(`${value.toFixed(marks.digits)} s`, at, TOP + height + 4);
      }
    }
  }
}
