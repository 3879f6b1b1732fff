// One or two drives on the same scenario. What is moved while they run is recorded with its
// decision, so that the run can be repeated to the bit.

import { Drive } from "./drive.js";
import { History } from "./history.js";

const BINS = 20000; // decisions kept for the plots: 20 s
const MOST_MOVES = 1500; // beyond that, a link only holds the present levers

// A target that is a node of a table: "a12" or "b12", that of drive A or B; "a12*", in all slices.
export const NODE = /^([ab])(\d+)(\*?)$/;

export class Run {
  constructor(core) {
    this.core = core;
    this.drives = [new Drive(core), new Drive(core)];
    this.histories = this.drives.map(() => new History(core, BINS));
    this.onFault = () => {};
  }

  // setup: motor, seed, seek, sides (estimator and rule of each drive in use), levers, moves.
  start(setup) {
    this.setup = setup;
    this.levers = { ...setup.levers };
    this.moves = setup.moves.slice(); // [decision, target, value]
    this.complete = true;
    this.upcoming = 0;
    this.decision = 0;
    this.faults = [0, 0];
    this.lost = [0, 0];
    this.lostAt = [0, 0]; // [s]
    this.sides.forEach((side, i) => this.drives[i].start(setup.motor, side, this.levers, setup));
    this.histories.forEach((history) => history.clear());
    this.makeMoves();
  }

  get sides() {
    return this.setup.sides;
  }

  get seconds() {
    return this.decision * this.decisionTime;
  }

  get decisionTime() {
    return this.setup.motor.periods * this.setup.motor.T_s;
  }

  get over() {
    return this.sides.every((_, i) => this.lost[i] !== 0);
  }

  // Moves a lever or a node of a table now.
  move(target, value) {
    const last = this.moves[this.upcoming - 1];
    const again = last && last[0] === this.decision && last[1] === target;
    if (again) last[2] = value;
    else this.moves.splice(this.upcoming++, 0, [this.decision, target, value]);
    if (this.upcoming > MOST_MOVES) this.complete = false;
    this.apply(target, value);
  }

  apply(target, value) {
    const node = NODE.exec(target);
    if (node) {
      this.drives[node[1] === "a" ? 0 : 1].table.set(Number(node[2]), value, node[3] === "*");
      return;
    }
    this.levers[target] = value;
    this.sides.forEach((_, i) => this.drives[i].pull(target, value));
  }

  makeMoves() {
    while (this.upcoming < this.moves.length && this.moves[this.upcoming][0] <= this.decision) {
      const [, target, value] = this.moves[this.upcoming++];
      this.apply(target, value);
    }
  }

  // One decision of every drive.
  advance() {
    this.makeMoves();
    for (let i = 0; i < this.sides.length; i++) {
      if (this.lost[i] !== 0) continue;
      const drive = this.drives[i];
      this.histories[i].add(drive.decide());
      this.notice(i, drive);
    }
    this.decision += 1;
  }

  notice(i, drive) {
    const faults = drive.get("drive.x.fault");
    const lost = drive.lost;
    const told = (kind, bits) => {
      for (const bit of Object.keys(this.core.layout[kind])) {
        if (bits & Number(bit)) this.onFault(i, this.seconds, this.core.layout[kind][bit], kind);
      }
    };
    told("faults", faults & ~this.faults[i]);
    told("lost", lost & ~this.lost[i]);
    if (lost !== 0 && this.lost[i] === 0) this.lostAt[i] = this.seconds;
    this.faults[i] = faults;
    this.lost[i] = lost;
  }
}
