// The plots of the page: which curves, their legends, and a cursor through all of them.

import { LEFT, Plot, source } from "./plot.js";

const both = (name, a = "A", b = "B") => [
  { name, side: 0, colour: "a", text: a },
  { name, side: 1, colour: "b", text: b },
];
const reference = (name, text) => ({ name, side: 0, colour: "muted", text, common: true, thin: true });

function kinds(motor) {
  const { rpm, tau, u_dc, i_rated } = motor;
  return [
    { key: "speed", title: "Speed", unit: "r/min", range: [0, rpm / 4], round: 0,
      curves: [reference("speed_ref", "reference"), ...both("speed")] },
    { key: "torque", title: "Torque", unit: "N m", range: [-tau / 4, tau / 4], round: 2,
      curves: [reference("load", "load"), ...both("torque")] },
    { key: "err", title: "Angle error of the drive", unit: "°", range: [-5, 5], round: 1, most: 45,
      curves: both("err") },
    { key: "hfi", title: "Angle error of the injection", unit: "°", range: [-10, 10], round: 1,
      most: 45, curves: both("err_hfi") },
    { key: "observer", title: "Angle error of the observer", unit: "°", range: [-10, 10], round: 1,
      most: 45, curves: both("err_observer") },
    { key: "k_s", title: "Weight of the injection k_s", unit: "", range: [-0.05, 1.05], fixed: true,
      round: 2, curves: both("k_s") },
    { key: "voltage", title: "Voltage", unit: "V", range: [0, u_dc / 4], round: 0,
      curves: [reference("limit", "limit"), ...both("voltage")], first_hidden: ["limit"] },
    { key: "current", title: "Current", unit: "A", range: [0, i_rated / 2], round: 2,
      curves: both("current"), off: true },
  ];
}

export class Plots {
  constructor(root, chooser) {
    this.root = root;
    this.chooser = chooser;
    this.cursor = null; // share of the width under the pointer
    this.marks = [];
    this.off = null;
    root.addEventListener("pointermove", (event) => this.point(event));
    root.addEventListener("pointerdown", (event) => this.point(event));
    root.addEventListener("pointerleave", () => { this.cursor = null; });
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.readColours());
    this.readColours();
  }

  readColours() {
    const style = getComputedStyle(document.documentElement);
    const names = ["a", "b", "muted", "grid", "zero", "text"];
    this.look = Object.fromEntries(names.map((n) => [n, style.getPropertyValue(`--${n}`).trim()]));
    this.look.font = "11px system-ui, sans-serif";
  }

  build(motor) {
    const all = kinds(motor);
    this.off ??= new Set(all.filter((k) => k.off).map((k) => k.key));
    this.root.replaceChildren();
    this.chooser.replaceChildren();
    this.plots = all.map((kind) => this.one(kind));
    this.share();
  }

  // The plots share the height of the window.
  share() {
    this.root.style.setProperty("--plots", this.plots.filter((p) => !p.figure.hidden).length);
  }

  one(kind) {
    const figure = document.createElement("figure");
    const head = document.createElement("figcaption");
    const title = document.createElement("span");
    title.className = "title";
    title.textContent = kind.unit ? `${kind.title} [${kind.unit}]` : kind.title;
    head.append(title);
    const canvas = document.createElement("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${title.textContent} over time; the table Now has the values`);
    const plot = new Plot(canvas, kind);
    plot.keys = kind.curves.map((curve) => {
      const key = document.createElement("button");
      key.type = "button";
      key.className = `key ${curve.colour}`;
      key.addEventListener("click", () => this.toggle(plot, curve.text, key));
      head.append(key);
      if (kind.first_hidden?.includes(curve.text)) plot.hidden.add(curve.text);
      key.setAttribute("aria-pressed", String(!plot.hidden.has(curve.text)));
      return key;
    });
    figure.append(head, canvas);
    figure.hidden = this.off.has(kind.key);
    this.root.append(figure);
    this.choice(kind, figure);
    plot.figure = figure;
    return plot;
  }

  choice(kind, figure) {
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = !figure.hidden;
    box.addEventListener("change", () => {
      figure.hidden = !box.checked;
      this.off[box.checked ? "delete" : "add"](kind.key);
      this.share();
    });
    label.append(box, kind.title);
    this.chooser.append(label);
  }

  toggle(plot, text, key) {
    plot.hidden[plot.hidden.has(text) ? "delete" : "add"](text);
    key.setAttribute("aria-pressed", String(!plot.hidden.has(text)));
  }

  point(event) {
    const canvas = event.target.closest("canvas");
    if (!canvas) return;
    const width = canvas.clientWidth - LEFT - 8;
    const share = (event.offsetX - LEFT) / width;
    this.cursor = share >= 0 && share <= 1 ? share : null;
  }

  draw(run, seconds) {
    const span = Math.round(seconds / run.decisionTime);
    const end = Math.max(run.decision, span);
    const cursor = this.cursor === null ? null : Math.floor(end - span + this.cursor * span);
    const visible = this.plots.filter((plot) => !plot.figure.hidden);
    const frame = {
      span, end, histories: run.histories, decisionTime: run.decisionTime, marks: this.marks,
      look: this.look, cursor, sides: run.sides.length,
    };
    visible.forEach((plot, j) => {
      plot.draw({ ...frame, last: j === visible.length - 1 });
      plot.what.curves.forEach((curve, k) => this.label(plot, curve, plot.keys[k], run, cursor));
    });
  }

  // A legend names its curve, and its value at the cursor.
  label(plot, curve, key, run, cursor) {
    key.hidden = curve.side >= run.sides.length;
    const history = source(curve, run.histories);
    let text = curve.text;
    if (cursor !== null && cursor >= history.first && cursor < history.count) {
      const slot = cursor % history.bins;
      const value = (history.low[curve.name][slot] + history.high[curve.name][slot]) / 2;
      text += ` ${value.toFixed(plot.what.round).replace("-", "−")}`;
    }
    if (key.textContent !== text) key.textContent = text;
  }
}
