// The page: one run, its controls, and its pictures.

import { toBase64, unpack } from "./bytes.js";
import { Core } from "./core.js";
import { Levers } from "./levers.js";
import { fromLink, toLink } from "./link.js";
import { Pace } from "./pace.js";
import { Plots } from "./plots.js";
import { PRESETS, scenario } from "./presets.js";
import { Readout } from "./readout.js";
import { NODE, Run } from "./run.js";
import { Sides, sideOf } from "./sides.js";
import { TableEditor } from "./table_editor.js";

const FIRST = "reversal"; // scenario of the first run
const PACES = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];

const $ = (id) => document.getElementById(id);

class Page {
  constructor(core) {
    this.core = core;
    this.layout = core.layout;
    this.run = new Run(core);
    this.run.onFault = (...what) => this.fault(...what);
    this.plots = new Plots($("plots"), $("shown"));
    this.readout = new Readout($("now"), $("events"), [$("drive-A"), $("drive-B")]);
    this.levers = new Levers($("levers"), $("sensors"), (name, value) =>
      this.run.move(name, value));
    this.sides = new Sides([$("side-A"), $("side-B")], $("compare"), this.layout, (sides) =>
      this.again({ sides }));
    this.editor = new TableEditor(
      { root: $("curve"), slices: $("slices"), all: $("all-slices"), status: $("check") },
      (node, value, all) => this.run.move(`${"ab"[this.edited]}${node}${all ? "*" : ""}`, value));
    this.edited = 0;
    this.choices();
    this.keys();
    new ResizeObserver(([{ target }]) => // plots stay below it on a phone
      document.documentElement.style.setProperty("--header", `${target.offsetHeight}px`),
    ).observe(document.querySelector("header"));
    this.open();
    this.pace = new Pace(this.run, () => this.draw());
    if (this.goal > 0) this.pace.hurryTo(this.goal);
    else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.pace.start();
    window.addEventListener("hashchange", () => this.open());
  }

  choices() {
    $("untabled").textContent = this.layout.untabled.join(", ");
    const motors = this.layout.motors.map((m) => new Option(`${m.name}: ${m.text}`, m.name));
    $("motor").replaceChildren(...motors);
    $("scenario").replaceChildren(
      ...Object.entries(PRESETS).map(([key, { text }]) => new Option(text, key)));
    $("motor").addEventListener("change", () => this.newMotor());
    $("scenario").addEventListener("change", () => this.again(this.chosen(this.motor)));
    $("seek").addEventListener("change", () => this.again({ seek: $("seek").checked }));
    $("seed").addEventListener("change", () => {
      const seed = Math.floor(Number($("seed").value)) || 0;
      this.again({ seed: Math.min(Math.max(seed, 0), this.layout.seeds.length - 1) });
    });
    $("run").addEventListener("click", () => this.toggle());
    $("restart").addEventListener("click", () => this.again());
    $("share").addEventListener("click", () => this.share());
    $("factor").addEventListener("input", () => this.setFactor(Number($("factor").value)));
    for (const [i, name] of ["A", "B"].entries()) {
      $(`edit-${name}`).addEventListener("change", () => this.edit(i));
    }
    $("reset-table").addEventListener("click", () => this.resetTable());
  }

  // Space runs and pauses, R restarts, unless a control has the key's use.
  keys() {
    document.addEventListener("keydown", (event) => {
      const { tagName, type } = event.target;
      if (event.ctrlKey || event.metaKey || event.altKey || tagName === "SELECT") return;
      if (["BUTTON", "SUMMARY"].includes(tagName) || (tagName === "INPUT" && type !== "range")) return;
      if (event.key === " ") this.toggle();
      else if (event.key === "r" || event.key === "R") this.again();
      else return;
      event.preventDefault();
    });
  }

  // The run of the address, or else the first one.
  open() {
    const found = fromLink(location.hash, this.layout);
    if (location.hash.length > 1 && !found) {
      this.say("This link is not one of this page's: it shows its first run.");
    }
    if (found && !found.same) {
      this.say("This link was made with another version of the core: its run may differ.");
    }
    const motor = found?.setup.motor ?? this.layout.motors[0];
    const sides = ["sliding_mode", "reference"].map((word) => sideOf(word, motor, this.layout));
    const first = { motor, seed: 0, seek: false, sides, ...scenario(FIRST, motor) };
    if (!found) $("scenario").value = FIRST;
    this.begin(found?.setup ?? first);
    this.goal = found?.decision ?? 0;
    if (this.pace && this.goal > 0) this.pace.hurryTo(this.goal);
  }

  // Levers and moves of the scenario chosen; none of its own: the levers stay.
  chosen(motor) {
    const name = $("scenario").value;
    return name === "free" && motor === this.motor
      ? { levers: { ...this.run.levers }, moves: [] }
      : scenario(name, motor);
  }

  // Starts anew, perhaps with something changed. What was set by hand stays: levers that the
  // scenario does not move, and the tables of drives that keep their rule.
  again(changes = {}) {
    const { setup, levers, moves, upcoming } = this.run;
    const scheduled = setup.moves.filter(([, target]) => !NODE.test(target));
    const taken = new Set(scheduled.map(([, target]) => target));
    const start = Object.entries(levers).map(([name, value]) =>
      [name, taken.has(name) ? setup.levers[name] : value]);
    const sides = changes.sides ?? setup.sides;
    const nodes = new Map();
    for (const [, target, value] of moves.slice(0, upcoming)) {
      const i = "ab".indexOf(target[0]);
      if (!NODE.test(target) || sides[i]?.rule !== setup.sides[i]?.rule) continue;
      nodes.delete(target); // the last one counts
      nodes.set(target, value);
    }
    const next = { ...setup, levers: Object.fromEntries(start), moves: scheduled, ...changes };
    next.moves = [...[...nodes].map(([target, value]) => [0, target, value]), ...next.moves];
    this.begin(next);
    this.pace.start();
  }

  begin(setup) {
    const { motor } = setup;
    if (this.motor !== motor) {
      this.motor = motor;
      this.levers.build(motor);
      this.plots.build(motor);
    }
    $("motor").value = motor.name;
    $("seek").checked = setup.seek;
    $("seek").disabled = !motor.seeks;
    $("seed").value = setup.seed;
    this.readout.clear();
    this.plots.marks = [];
    this.run.start(setup);
    this.sides.show(motor, setup.sides);
    $("edit-B").parentElement.hidden = setup.sides.length < 2;
    this.edit(setup.sides.length < 2 ? 0 : this.edited);
  }

  newMotor() {
    const motor = this.layout.motors.find((m) => m.name === $("motor").value);
    const like = ({ estimator, rule }) => {
      const same = motor.rules.find((r) => r.word === rule.word) ?? motor.rules[0];
      return { estimator: same.estimator ?? estimator, rule: same };
    };
    const { sides, seed, seek } = this.run.setup;
    this.begin({
      motor, seed, seek: seek && motor.seeks, sides: sides.map(like), ...this.chosen(motor),
    });
    this.pace.start();
  }

  edit(side) {
    this.edited = side;
    $(`edit-${"AB"[side]}`).checked = true;
    this.editor.show(this.run.drives[side], side);
  }

  resetTable() {
    const { rule } = this.run.sides[this.edited];
    const table = this.run.drives[this.edited].table;
    const now = table.values.slice();
    table.load(rule);
    const nominal = table.values.slice();
    nominal.forEach((value, node) => {
      if (value !== now[node]) this.run.move(`${"ab"[this.edited]}${node}`, value);
    });
    this.editor.update();
  }

  fault(side, seconds, text, kind) {
    this.readout.add(side, seconds, text, kind);
    this.plots.marks.push({ decision: this.run.decision, side });
  }

  toggle() {
    if (this.run.over) this.again();
    else this.pace[this.pace.running ? "stop" : "start"]();
  }

  setFactor(value) {
    this.pace.factor = PACES[value];
    $("factor-text").textContent = `${this.pace.factor}×`;
    $("factor").setAttribute("aria-valuetext", `${this.pace.factor} times real time`);
  }

  async share() {
    const link = toLink(this.run);
    history.replaceState(null, "", link);
    const course = this.run.complete ? "" : "; too much was moved to repeat its course: it has the levers";
    let text = "The address of this page now holds this run";
    try {
      await navigator.clipboard.writeText(location.href);
      text += " and is on the clipboard";
    } catch { /* not allowed here: the address bar has it */ }
    this.say(`${text}${course}.`);
  }

  say(text) {
    $("message").textContent = text;
  }

  draw() {
    const { run, pace } = this;
    const seconds = Number($("window").value);
    this.levers.follow(run.levers);
    this.plots.draw(run, seconds);
    if (run.decision !== this.followed) this.editor.follow();
    this.followed = run.decision;
    this.slow = (this.slow ?? 0) + 1;
    if (this.slow % 6 !== 0) return; // text that changes faster cannot be read
    this.readout.show(run, Math.round(seconds / run.decisionTime));
    const label = pace.running ? "Pause" : "Run";
    if ($("run").textContent !== label) $("run").textContent = label;
    $("clock").textContent = `${run.seconds.toFixed(2)} s`;
    const slow = pace.running && pace.until <= run.decision && pace.reached < 0.8 * pace.factor;
    const reached = `this computer reaches ${pace.reached.toFixed(0)}×`;
    $("reached").textContent = slow && pace.factor > 1 ? reached : "";
  }
}

async function main() {
  const text = (id) => $(id).textContent.trim();
  const [wasm, image] = await Promise.all([unpack(text("wasm")), unpack(text("image"))]);
  const core = await Core.load(wasm, image, JSON.parse(text("layout")));
  const page = new Page(core);
  $("core").textContent = core.layout.core;
  // For tests and the curious: the page, and the bytes of a drive's record.
  window.playground = { page, state: (i) => toBase64(page.run.drives[i].state()) };
}

main().catch((error) => {
  $("message").textContent =
    `The page cannot run here: ${error.message}. It needs a browser of 2023 or later.`;
  throw error;
});
