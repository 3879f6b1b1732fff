// One drive with its machine and its sensored twin: a record of the core, and its table.

import { Table } from "./table.js";

export class Drive {
  constructor(core) {
    this.core = core;
    this.at = core.room(core.layout.sizes.sim);
    this.table = new Table(core);
  }

  // Puts the drive at the start of a run. levers: values by name, in the units of the page.
  start(motor, { estimator, rule }, levers, { seed, seek }) {
    const core = this.core;
    this.motor = motor;
    this.template = core.image + motor.sims[estimator];
    core.copy(this.template, this.at, core.layout.sizes.sim);
    this.table.load(rule);
    this.set("seed", core.layout.seeds[seed]);
    this.set("start.seek", seek ? 1 : 0);
    for (const [name, value] of Object.entries(levers)) this.pull(name, value);
    core.lib.sim_start(this.at, 1);
  }

  get(path) {
    const [offset, kind] = this.core.layout.fields[path];
    return this.core.read(this.at + offset, kind);
  }

  set(path, value) {
    const [offset, kind] = this.core.layout.fields[path];
    this.core.write(this.at + offset, kind, value);
  }

  // Sets one lever: what the drive is asked for, or how its machine differs from its file.
  pull(name, value) {
    const { motor, core } = this;
    const unit = core.layout.rpm;
    if (name === "speed") this.set("profile.omega_ref", motor.n_p * (unit * value));
    else if (name === "ramp") this.set("profile.omega_step", this.step(motor.n_p * (value * unit), value));
    else if (name === "load") this.set("profile.tau", value);
    else if (name === "offset") this.set("sensor.offset_a", value);
    else if (name === "gain") this.set("sensor.gain_a", value / 100);
    else if (name === "link") this.set("profile.u_dc", motor.u_dc * (value / 100));
    else this.scale(motor.levers[name], value / 100);
  }

  // Largest change a period for a rate per second; a rate of 0 means a step.
  step(rate, value) {
    return value === 0 ? 1e9 : Math.min(rate * this.motor.T_s, 1e9);
  }

  scale(parameters, factor) {
    for (const [offset, kind, how] of parameters) {
      const nominal = this.core.read(this.template + offset, kind);
      const value = how === "times" ? nominal * factor : nominal / factor;
      this.core.write(this.at + offset, kind, value);
    }
  }

  // One decision and its periods; returns the number of rows in core.rows.
  decide() {
    const { lib, rowsAt } = this.core;
    return lib.page_decide(this.at, this.table.at, this.table.valuesAt, this.motor.periods, rowsAt);
  }

  // Present signals of a schedule by name.
  signals() {
    const { lib, layout, signals, signalsAt } = this.core;
    lib.sim_signals(this.at, 1, signalsAt);
    return Object.fromEntries(layout.signals.map((name, j) => [name, signals[j]]));
  }

  get lost() {
    return this.get("lost");
  }

  // All bytes of the record: what a native run is compared with.
  state() {
    return this.core.bytes.slice(this.at, this.at + this.core.layout.sizes.sim);
  }
}
