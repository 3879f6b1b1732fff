// How fast a run goes: so many seconds of it in a second, as far as the computer can.

const SHARE = 0.8; // of the time between two frames is for computing
const LEAST = 13; // but at least so much [ms],
const MOST = 28; // and at most: pictures shall still move
const CHUNK = 16; // decisions between two looks at the clock

export class Pace {
  constructor(run, onFrame) {
    this.run = run;
    this.onFrame = onFrame;
    this.factor = 1;
    this.running = false;
    this.reached = 0; // factor over the last frames
    this.owed = 0; // decisions that are due
    this.until = 0; // decision up to which the run hurries, then it stops
    requestAnimationFrame((now) => this.frame(now, now));
  }

  start() {
    this.running = true;
    this.owed = 0;
    this.until = 0;
  }

  stop() {
    this.running = false;
    this.reached = 0;
  }

  // Repeats a run up to a decision as fast as it can.
  hurryTo(decision) {
    this.start();
    this.until = decision;
  }

  frame(now, before) {
    const elapsed = Math.min((now - before) / 1000, 0.1);
    const was = this.run.decision;
    if (this.running) this.compute(elapsed);
    const made = (this.run.decision - was) * this.run.decisionTime;
    if (this.running && elapsed > 0) this.reached += 0.1 * (made / elapsed - this.reached);
    this.onFrame();
    requestAnimationFrame((next) => this.frame(next, now));
  }

  compute(elapsed) {
    const hurry = this.until > this.run.decision;
    this.owed = hurry ? Infinity : this.owed + (elapsed * this.factor) / this.run.decisionTime;
    const end = performance.now() + Math.min(Math.max(SHARE * 1000 * elapsed, LEAST), MOST);
    while (this.owed >= 1) {
      this.run.advance();
      this.owed -= 1;
      if (this.run.over || (hurry && this.run.decision >= this.until)) return this.stop();
      if (this.run.decision % CHUNK === 0 && performance.now() > end) break;
    }
    if (this.owed >= 1) this.owed = 0; // the computer is too slow: the rest is not made up for
  }
}
