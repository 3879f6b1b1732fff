// What each drive is and how it fares, its present values as a table, its faults as a list.

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
  constructor(table, list, names) {
    this.table = table;
    this.list = list;
    this.names = names;
    this.cells = ROWS.map(([text, , , unit]) => {
      const row = table.tBodies[0].insertRow();
      const head = document.createElement("th");
      head.scope = "row";
      head.textContent = unit ? `${text} [${unit}]` : text;
      row.append(head);
      return [row.insertCell(), row.insertCell()];
    });
  }

  show(run, span) {
    ROWS.forEach(([, name, digits, , kind], j) => {
      this.cells[j].forEach((cell, i) => {
        const history = run.histories[i];
        const value = kind === "largest" ? history.largest(name, span) : history.latest(name);
        const known = i < run.sides.length && isFinite(value);
        cell.classList.toggle("stale", run.lost[i] !== 0); // of the moment it was lost
        put(cell, known ? value.toFixed(digits).replace("-", "−") : "–");
      });
    });
    this.table.classList.toggle("one", run.sides.length < 2);
    this.names.forEach((name, i) => {
      name.hidden = i >= run.sides.length;
      if (name.hidden) return;
      const { estimator, rule } = run.sides[i];
      put(name.children[1], `${run.core.layout.estimators[estimator]}; ${rule.text}`);
      put(name.children[2], state(run, i));
      name.classList.toggle("lost", run.lost[i] !== 0 || run.faults[i] !== 0);
      name.classList.toggle("fine", name.children[2].textContent === run.core.layout.phases[0]);
    });
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
  const { faults, lost, phases } = run.core.layout;
  const told = (words, bits) =>
    Object.keys(words).filter((bit) => bits & Number(bit)).map((bit) => words[bit]);
  if (run.lost[i] !== 0) {
    return told(lost, run.lost[i]).join("; ").replace("lost:", `lost at ${run.lostAt[i].toFixed(2)} s:`);
  }
  const phase = phases[run.drives[i].get("drive.x.start.phase")];
  return [...told(faults, run.faults[i]), phase].join("; ");
}
