// Scenarios: levers at the start, and what moves when. Speeds are shares of the rated speed, loads
// of the rated torque, ramps rated speeds per second (0: steps), offsets amperes; the others are in
// percent.

export const NOMINAL = {
  ...{ speed: 0, ramp: 0, load: 0, resistance: 100, magnet: 100, inertia: 100, link: 100 },
  ...{ gain: 100, offset: 0 },
};

export const PRESETS = {
  free: {
    text: "None: the levers alone",
    start: { speed: 0.1, ramp: 0.5 },
    moves: [],
  },
  reversal: {
    text: "Sudden reversal under load",
    start: { speed: 0.4, load: 0.6 },
    moves: [[1.5, "speed", -0.4], [4, "speed", 0.4]],
  },
  fig9: {
    text: "Steps of the paper's Fig. 9, no load",
    start: { speed: 200 / 1500 },
    moves: [[1, "speed", 350 / 1500], [2, "speed", 0.4]],
  },
  ramp: {
    text: "Ramp up and down under half load",
    start: { speed: 0.06, ramp: 0.25, load: 0.5 },
    moves: [[1, "speed", 0.6], [5, "speed", 0.06]],
  },
  step: {
    text: "Load steps in the middle of the hand-over",
    start: { speed: 0.23, ramp: 1 },
    moves: [[1, "load", 0.8], [2, "load", 0], [3, "load", -0.6], [4, "load", 0]],
  },
  hot: {
    text: "Hot winding, weak magnet, hand-over",
    start: { speed: 0.1, ramp: 0.3, load: 0.6, resistance: 140, magnet: 88 },
    moves: [[1, "speed", 0.5], [4, "speed", 0.1]],
  },
  sag: {
    text: "The DC link sags at rated speed",
    start: { speed: 0.3, ramp: 1, load: 0.3 },
    moves: [[0.3, "speed", 1], [2.5, "link", 70], [4, "link", 100]],
  },
  sensor: {
    text: "A current sensor drifts, then dies",
    start: { speed: 0.12, ramp: 1, load: 0.4 },
    moves: [[1, "gain", 110], [2, "gain", 130], [3, "gain", 0]],
  },
  hold: {
    text: "Holding a load at standstill",
    start: { speed: 0, ramp: 1 },
    moves: [[0.5, "load", 0.8], [2, "load", 0]],
  },
};

// Levers and moves of a scenario on a machine, in the units of the page.
export function scenario(name, motor) {
  const unit = { speed: motor.rpm, ramp: motor.rpm, load: motor.tau };
  const to = (lever, x) => (unit[lever] ? x * unit[lever] : x);
  const { start, moves } = PRESETS[name];
  const levers = Object.entries({ ...NOMINAL, ...start }).map(([key, x]) => [key, to(key, x)]);
  const decision = motor.periods * motor.T_s;
  return {
    levers: Object.fromEntries(levers),
    moves: moves.map(([t, lever, x]) => [Math.round(t / decision), lever, to(lever, x)]),
  };
}
