// The present values of both drives as a table, and what happened to them as a list.

const ROWS = [
  ["Speed", "speed", 0, "r/min"],
  ["Torque", "torque", 2, "N m"],
  ["Angle error", "err", 1, "°"],
  ["largest in view", "err", 1, "°", "largest"],
  ["k_s", "k_s", 2, ""],
  ["Voltage", "voltage", 0, "V"],
  ["Current", "current", 2, "A"],
];
const MOST_EVENTS = 50;

export class Readout {
  constructor(body, list) {
    this.list = list;
    this.cells = ROWS.map(([text, , , unit]) => {
      const row = body.insertRow();
      const head = document.createElement("th");
      head.scope = "row";
      head.textContent = unit ? `${text} [${unit}]` : text;
      row.append(head);
      return [row.insertCell(), row.insertCell()];
    });
    const row = body.insertRow();
    const head = document.createElement("th");
    head.scope = "row";
    head.textContent = "State";
    row.append(head);
    this.states = [row.insertCell(), row.insertCell()];
  }

  show(run, span) {
    ROWS.forEach(([, name, digits, , kind], j) => {
      this.cells[j].forEach((cell, i) => {
        const history = run.histories[i];
        const value = kind === "largest" ? history.largest(name, span) : history.latest(name);
        const known = i < run.sides.length && isFinite(value);
        put(cell, known ? value.toFixed(digits).replace("-", "−") : "–");
      });
    });
    this.states.forEach((cell, i) => put(cell, i < run.sides.length ? state(run, i) : "–"));
  }

  clear() {
    this.list.replaceChildren();
  }

  add(side, seconds, text, kind) {
    const item = document.createElement("li");
    item.className = kind;
    item.textContent = `${seconds.toFixed(2)} s, drive ${"AB"[side]}: ${text}`;
    this.list.prepend(item);
    while (this.list.childElementCount > MOST_EVENTS) this.list.lastChild.remove();
  }
}

function put(cell, text) {
  if (cell.textContent !== text) cell.textContent = text;
}

function state(run, i) {
  if (run.lost[i] !== 0) return "stopped";
  const phase = run.drives[i].get("drive.x.start.phase");
  return run.core.layout.phases[phase];
}
