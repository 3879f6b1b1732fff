// The sliders that change what a drive meets while it runs.

import { digits, roundUp } from "./axis.js";

const PERCENT = { unit: "%", step: 1 };

// What each lever is on a machine.
function levers(motor) {
  const speed = roundUp(motor.rpm / 200);
  const load = roundUp(motor.tau / 100);
  const offset = roundUp(motor.i_rated / 200);
  const edge = (x, step) => Math.ceil(x / step) * step;
  return [
    { name: "speed", text: "Speed reference", unit: "r/min", step: speed,
      low: -edge(1.2 * motor.rpm, speed), high: edge(1.2 * motor.rpm, speed) },
    { name: "load", text: "Load torque", unit: "N m", step: load,
      low: -edge(1.5 * motor.tau, load), high: edge(1.5 * motor.tau, load) },
    { name: "ramp", text: "Ramp of the reference", unit: "r/min/s", step: 10 * speed, low: 0,
      high: edge(4 * motor.rpm, 10 * speed), zero: "steps" },
    { name: "resistance", text: "Winding resistance", low: 50, high: 200, ...PERCENT },
    { name: "magnet", text: "Magnet flux", low: 60, high: 120, ...PERCENT },
    { name: "inertia", text: "Inertia", low: 25, high: 500, ...PERCENT, step: 5 },
    { name: "link", text: "DC-link voltage", low: 40, high: 120, ...PERCENT },
    { name: "gain", text: "Gain of current sensor a", low: 0, high: 200, rare: true,
      ...PERCENT },
    { name: "offset", text: "Offset of current sensor a", unit: "A", step: offset, rare: true,
      low: -edge(0.5 * motor.i_rated, offset), high: edge(0.5 * motor.i_rated, offset) },
  ];
}

export class Levers {
  constructor(root, rare, onMove) {
    this.root = root;
    this.rare = rare;
    this.onMove = onMove;
  }

  build(motor) {
    this.rows = levers(motor).map((lever) => this.row(lever));
    const elements = (rare) =>
      this.rows.filter((row) => Boolean(row.lever.rare) === rare).map((row) => row.element);
    this.root.replaceChildren(...elements(false));
    this.rare.replaceChildren(...elements(true));
  }

  row(lever) {
    const element = document.createElement("div");
    element.className = "lever";
    const label = document.createElement("label");
    label.htmlFor = `lever-${lever.name}`;
    label.textContent = lever.text;
    const output = document.createElement("output");
    output.htmlFor = label.htmlFor;
    const input = document.createElement("input");
    Object.assign(input, {
      type: "range", id: label.htmlFor, min: lever.low, max: lever.high, step: lever.step,
    });
    input.addEventListener("input", () => {
      this.show({ lever, input, output }, Number(input.value));
      this.onMove(lever.name, Number(input.value));
    });
    element.append(label, output, input);
    return { lever, input, output, element };
  }

  show({ lever, input, output }, value) {
    const number = value.toFixed(digits(lever.step)).replace("-", "−");
    const text = value === 0 && lever.zero ? lever.zero : `${number} ${lever.unit}`;
    if (output.textContent === text) return;
    output.textContent = text;
    input.setAttribute("aria-valuetext", text);
  }

  // Shows the levers of a run, which a scenario may move too.
  follow(values) {
    for (const row of this.rows) {
      const value = values[row.lever.name];
      if (row.shown === value) continue;
      row.shown = value;
      if (Number(row.input.value) !== value) row.input.value = value;
      this.show(row, value);
    }
  }
}
