// A run as the part of the address after "#", which never leaves the browser.
//
//   m motor; a, b estimator and rule of the drives; s seed; k 1: the rotor is found first;
//   l levers at the start; v moves: decision, target, value; t decision at which the run was shared;
//   c core that ran it

import { NOMINAL } from "./presets.js";
import { NODE } from "./run.js";

const LEVER_NAMES = Object.keys(NOMINAL);

export function toLink(run) {
  const { motor, sides, seed, seek, levers } = run.setup;
  const out = new URLSearchParams();
  out.set("c", run.core.layout.core);
  out.set("m", motor.name);
  sides.forEach((side, i) => out.set("ab"[i], `${side.estimator} ${side.rule.word}`));
  if (seed) out.set("s", seed);
  if (seek) out.set("k", 1);
  const at = run.complete ? levers : run.levers;
  out.set("l", LEVER_NAMES.map((name) => at[name]).join(" "));
  if (run.complete) {
    if (run.moves.length) out.set("v", run.moves.map((move) => move.join("_")).join(" "));
    out.set("t", run.decision);
  }
  return `#${out.toString().replaceAll("%2C", ",").replaceAll("%3A", ":").replaceAll("%2A", "*")}`;
}

// The setup that a link describes, and the decision to go to; null if it is none that this page
// understands.
export function fromLink(hash, layout) {
  const found = new URLSearchParams(hash.slice(1));
  const motor = layout.motors.find((m) => m.name === found.get("m"));
  if (!motor) return null;
  const sides = ["a", "b"].filter((key) => found.has(key)).map((key) => side(found.get(key), motor));
  const numbers = (found.get("l") ?? "").split(" ").map(Number);
  if (!sides.length || sides.includes(null)) return null;
  if (numbers.length !== LEVER_NAMES.length || !numbers.every(Number.isFinite)) return null;
  const moves = (found.get("v") ?? "").split(" ").filter(Boolean).map(move);
  if (!moves.every((m) => m && known(m[1], sides))) return null;
  return {
    setup: {
      motor,
      sides,
      seed: Math.min(whole(found.get("s")), layout.seeds.length - 1),
      seek: found.get("k") === "1" && motor.seeks,
      levers: Object.fromEntries(LEVER_NAMES.map((name, j) => [name, numbers[j]])),
      moves,
    },
    decision: whole(found.get("t")),
    same: (found.get("c") ?? layout.core) === layout.core,
  };
}

function side(text, motor) {
  const [estimator, word] = text.split(" ");
  const rule = motor.rules.find((r) => r.word === word);
  return rule && estimator in motor.sims ? { estimator, rule } : null;
}

function move(text) {
  const [, decision, target, value] = /^(\d+)_([a-z]+\d*\*?)_(-?[\d.]+(?:e-?\d+)?)$/.exec(text) ?? [];
  return decision === undefined ? null : [Number(decision), target, Number(value)];
}

function known(target, sides) {
  const node = NODE.exec(target);
  if (!node) return LEVER_NAMES.includes(target);
  const at = sides["ab".indexOf(node[1])];
  return at !== undefined && Number(node[2]) < at.rule.axes.reduce((n, axis) => n * axis.n, 1);
}

function whole(text) {
  const x = Number(text ?? 0);
  return Number.isSafeInteger(x) && x >= 0 ? x : 0;
}
