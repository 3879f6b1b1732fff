// The k_s table of a drive as a curve over its first axis, whose nodes can be dragged. Its other
// axes are chosen by sliders: a curve is one slice.

import { ticks } from "./axis.js";

const W = 340;
const H = 214;
const BOX = { left: 34, right: W - 14, top: 12, bottom: H - 38 };
const STEP = 0.05; // of an arrow key

const TEXT = {
  speed: ["Speed", "r/min", (m) => m.rpm],
  torque_current: ["Torque current", "of rated", () => 1],
  disagreement: ["Disagreement of the angles", "°", () => 30],
  acceleration: ["Acceleration", "rated speeds/s", () => 1],
};

function svg(name, attributes = {}) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
}

export class TableEditor {
  // onMove(node, value, all): a node was moved.
  constructor({ root, slices, all, status }, onMove) {
    Object.assign(this, { root, slices, all, status, onMove });
    this.picture = svg("svg", { viewBox: `0 0 ${W} ${H}`, role: "group" });
    root.replaceChildren(this.picture);
    this.picture.addEventListener("pointerdown", (event) => this.grab(event));
    this.picture.addEventListener("pointermove", (event) => this.drag(event));
    for (const name of ["pointerup", "pointercancel"]) {
      this.picture.addEventListener(name, () => { this.held = null; });
    }
  }

  // Shows the table of a drive from now on.
  show(drive, side) {
    this.drive = drive;
    this.table = drive.table;
    this.position = this.table.axes.slice(1).map((axis) => Math.floor((axis.n - 1) / 2));
    const [text, unit, scale] = TEXT[this.table.axes[0].signal] ?? [this.table.axes[0].signal, "", () => 1];
    this.scale = scale(drive.motor);
    this.axisText = `${text} [${unit}]`;
    this.picture.setAttribute("aria-label", `k_s of drive ${"AB"[side]} over ${text}`);
    this.picture.setAttribute("class", side === 0 ? "a" : "b");
    this.all.parentElement.hidden = this.table.axes.length < 2;
    this.build();
    this.chooseSlices();
    this.update();
  }

  build() {
    const { lo, hi, n } = this.table.axes[0];
    this.low = Math.min(0, lo);
    this.high = Math.max(1.08 * hi, Math.min(1.5 * hi, 0.6)); // outside, the table is constant
    this.picture.replaceChildren();
    for (const y of [0, 0.5, 1]) this.rule(BOX.left, this.y(y), BOX.right, this.y(y), String(y), "end");
    for (const value of ticks(this.low * this.scale, this.high * this.scale, 5).values) {
      const x = this.x(value / this.scale);
      this.rule(x, BOX.top, x, BOX.bottom, String(Math.round(value * 100) / 100), "middle");
    }
    const caption = svg("text", { x: BOX.right, y: H - 4, "text-anchor": "end" });
    caption.textContent = this.axisText;
    this.ghosts = svg("g", { class: "ghosts" });
    this.line = svg("polyline", { class: "line" });
    this.dot = svg("circle", { r: 5, class: "now" });
    this.picture.append(caption, this.ghosts, this.line, this.dot);
    this.nodes = Array.from({ length: n }, (_, j) => this.node(j, n));
    this.picture.append(...this.nodes);
  }

  rule(x1, y1, x2, y2, text, anchor) {
    const label = svg("text", {
      x: anchor === "end" ? x1 - 6 : x1, y: anchor === "end" ? y1 + 4 : y2 + 18, "text-anchor": anchor,
    });
    label.textContent = text;
    this.picture.append(svg("line", { x1, y1, x2, y2 }), label);
  }

  node(j, n) {
    const circle = svg("circle", {
      r: n > 30 ? 3.5 : 6, class: "node", tabindex: 0, role: "slider",
      "aria-valuemin": 0, "aria-valuemax": 1, "aria-orientation": "vertical",
    });
    const at = Math.round(this.table.nodeAt(0, j) * this.scale * 100) / 100;
    circle.setAttribute("aria-label", `k_s at ${at} ${this.axisText.replace(/.*\[|\]/g, "")}`);
    circle.addEventListener("keydown", (event) => {
      const by = { ArrowUp: STEP, ArrowRight: STEP, ArrowDown: -STEP, ArrowLeft: -STEP, Home: -1, End: 1 };
      if (!(event.key in by)) return;
      event.preventDefault();
      this.move(j, this.table.values[this.index(j)] + by[event.key]);
    });
    return circle;
  }

  // A slider for every further axis.
  chooseSlices() {
    this.slices.replaceChildren(...this.table.axes.slice(1).map((axis, a) => {
      const [text, unit, scale] = TEXT[axis.signal] ?? [axis.signal, "", () => 1];
      const row = document.createElement("div");
      row.className = "lever";
      const label = document.createElement("label");
      label.htmlFor = `slice-${a}`;
      label.textContent = `Slice: ${text}`;
      const output = document.createElement("output");
      const input = Object.assign(document.createElement("input"), {
        type: "range", id: label.htmlFor, min: 0, max: axis.n - 1, step: 1, value: this.position[a],
      });
      const show = () => {
        this.position[a] = Number(input.value);
        const value = this.table.nodeAt(a + 1, this.position[a]) * scale(this.drive.motor);
        output.textContent = `${String(Math.round(value * 100) / 100).replace("-", "−")} ${unit}`;
        input.setAttribute("aria-valuetext", output.textContent);
        this.update();
      };
      input.addEventListener("input", show);
      row.append(label, output, input);
      queueMicrotask(show);
      return row;
    }));
  }

  x(signal) {
    return BOX.left + ((BOX.right - BOX.left) * (signal - this.low)) / (this.high - this.low);
  }

  y(k_s) {
    return BOX.bottom + (BOX.top - BOX.bottom) * k_s;
  }

  // Node of the table at position j of the first axis in the slice chosen.
  index(j) {
    let at = j;
    this.table.axes.slice(1).forEach((axis, a) => { at = at * axis.n + this.position[a]; });
    return at;
  }

  grab(event) {
    const box = this.picture.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * W;
    const gaps = this.nodes.map((_, j) => Math.abs(this.x(this.table.nodeAt(0, j)) - x));
    const nearest = gaps.indexOf(Math.min(...gaps));
    if (gaps[nearest] > 24) return;
    this.held = nearest;
    this.picture.setPointerCapture(event.pointerId);
    this.nodes[nearest].focus({ preventScroll: true });
    this.drag(event);
  }

  drag(event) {
    if (this.held === null || this.held === undefined) return;
    const box = this.picture.getBoundingClientRect();
    const y = ((event.clientY - box.top) / box.height) * H;
    this.move(this.held, (BOX.bottom - y) / (BOX.bottom - BOX.top));
  }

  move(j, value) {
    const whole = Math.round(Math.min(Math.max(value, 0), 1) * 1000) / 1000;
    const all = this.table.axes.length > 1 && this.all.checked;
    this.onMove(this.index(j), whole, all);
    this.update();
  }

  // Draws the nodes where they are now.
  update() {
    const values = this.nodes.map((_, j) => this.table.values[this.index(j)]);
    const points = values.map((v, j) => `${this.x(this.table.nodeAt(0, j))},${this.y(v)}`);
    const ends = [`${BOX.left},${this.y(values[0])}`, `${BOX.right},${this.y(values.at(-1))}`];
    this.line.setAttribute("points", [ends[0], ...points, ends[1]].join(" "));
    this.nodes.forEach((node, j) => {
      node.setAttribute("cx", this.x(this.table.nodeAt(0, j)));
      node.setAttribute("cy", this.y(values[j]));
      node.setAttribute("aria-valuenow", values[j].toFixed(3));
    });
    const check = this.drive.core.layout.refusals[this.table.refused];
    this.status.textContent = `The firmware's check of this table: ${check}.`;
  }

  // Shows where the drive is: signal of the first axis, weight in force.
  follow() {
    const signal = this.drive.signals()[this.table.axes[0].signal];
    const inside = Math.min(Math.max(signal, this.low), this.high);
    this.dot.setAttribute("cx", this.x(inside || 0));
    this.dot.setAttribute("cy", this.y(this.drive.get("drive.x.k_s") || 0));
  }
}
