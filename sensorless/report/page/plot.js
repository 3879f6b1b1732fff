// Curves over time: drag to zoom, the values under the pointer stand in the legend.

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const drawn = new Map(); // place: uPlots in it
const HEIGHT = 170;
const FOLDED = ["current", "voltage", "faults"]; // panes that are shown only when asked for

// Axis that holds values which may be the same but for rounding.
function holding(low, high) {
  const differ = high - low > 1e-9 * Math.max(Math.abs(low), Math.abs(high));
  return differ ? uPlot.rangeNum(low, high, 0.06, true) : [low ? low - 1 : -0.1, low + 1];
}

function plot(place, { label, xLabel, x, curves, span, sync, bands = [], marks = [] }) {
  const [text, grid] = [colour("text"), colour("grid")];
  const axis = { stroke: text, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1 }, font: "12px system-ui", labelFont: "12px system-ui" };
  const number = (u, v) => (v === null || v === undefined ? "–" : v.toPrecision(4));
  const stripes = (u) => {
    const { ctx, bbox } = u;
    for (const [from, to, , name] of bands) {
      const [a, b] = [from, to].map((t) => Math.min(Math.max(u.valToPos(t, "x", true), bbox.left), bbox.left + bbox.width));
      ctx.fillStyle = colour(name);
      ctx.globalAlpha = name === "bad" ? 0.2 : 0.5;
      ctx.fillRect(a, bbox.top, b - a, bbox.height);
      ctx.globalAlpha = 1;
    }
  };
  const lines = (u) => {
    const { ctx, bbox } = u;
    const said = [...bands.map(([from, to, what, name]) => [(from + to) / 2, what, name === "faint" ? "muted" : name, false]), ...marks.map((m) => [...m, true])];
    const ratio = devicePixelRatio;
    ctx.font = `${12 * ratio}px system-ui`;
    said.forEach(([t, what, name, line], j) => {
      const at = u.valToPos(t, "x", true);
      if (at < bbox.left || at > bbox.left + bbox.width) return;
      ctx.fillStyle = colour(name);
      if (line) ctx.fillRect(at - ratio / 2, bbox.top, ratio, bbox.height);
      const right = at > bbox.left + 0.8 * bbox.width;
      ctx.textAlign = line ? (right ? "right" : "left") : "center";
      ctx.fillText(what, at + (line ? (right ? -4 : 4) * ratio : 0), bbox.top + (13 + 13 * (j % 3)) * ratio);
    });
  };
  const fit = (u, low, high) => (low === null ? [-0.1, 1] : holding(low, high));
  // The whole run has the given span. A range cannot tell: in it the time is still that of before.
  const spanned = (u, key) => {
    const { min, max } = u.scales.x;
    if (key !== "x" || !span || min > x[0] || max < x[x.length - 1]) return;
    queueMicrotask(() => u.setScale("y", { min: span[0], max: span[1] }));
  };
  const u = new uPlot(
    {
      width: Math.max(place.clientWidth, 200), height: HEIGHT,
      cursor: { sync: sync ? { key: sync } : undefined, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: { range: fit } },
      axes: [{ ...axis, label: xLabel, labelSize: xLabel ? 18 : 0, size: 30 }, { ...axis, size: 56, space: 28 }],
      series: [
        { label: "at", value: number },
        ...curves.map((c) => ({ label: c.name, stroke: colour(c.colour), width: c.width, value: number, spanGaps: Boolean(c.gaps), points: { show: Boolean(c.points), size: 5 }, dash: c.dash })),
      ],
      hooks: { drawClear: [stripes], draw: [lines], setScale: [spanned] },
    },
    [x, ...curves.map((c) => c.values)],
    place,
  );
  u.root.querySelector("canvas").setAttribute("role", "img");
  u.root.querySelector("canvas").setAttribute("aria-label", label);
  return u;
}

async function unpack(wave) {
  if (wave.t) return;
  const bytes = Uint8Array.from(atob(wave.data), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const raw = await new Response(stream).arrayBuffer();
  let at = 4 * wave.n;
  for (const curve of wave.panes.flatMap((p) => p.curves)) {
    const whole = new Int16Array(raw, at, wave.n);
    curve.values = Array.from(whole, (q) => (q === -32768 ? null : curve.low + curve.step * (q + 2000)));
    at += 2 * wave.n;
  }
  wave.t = Array.from(new Float32Array(raw, 0, wave.n));
}

// Axis that holds the curves of all waves.
function common(waves, j) {
  let [low, high] = [Infinity, -Infinity];
  for (const { panes } of waves) {
    if (panes[j].span) return panes[j].span;
    for (const { values } of panes[j].curves) for (const v of values) if (v !== null) [low, high] = [Math.min(low, v), Math.max(high, v)];
  }
  return low < high ? holding(low, high) : null;
}

// Only the first pane has their names.
function named(bands, marks, first) {
  const name = (what) => (first ? what : "");
  return { bands: bands.map(([from, to, what, c]) => [from, to, name(what), c]), marks: marks.map(([at, what, c]) => [at, name(what), c]) };
}

async function drawWaves(place) {
  const shown = place.dataset.case;
  const waves = data.cases[shown];
  await Promise.all(waves.map(unpack));
  if (place.dataset.case !== shown) return; // another case was asked for meanwhile
  const more = document.getElementById("more")?.checked;
  const plots = clear(place);
  const columns = waves.map((wave) => {
    const column = make("div");
    if (waves.length > 1) column.append(make("h4", wave.title));
    place.append(column);
    return column;
  });
  const visible = waves[0].panes.map((pane, j) => (!FOLDED.includes(pane.key) || more) && waves.some((w) => w.panes[j].curves.length));
  const last = visible.lastIndexOf(true);
  waves[0].panes.forEach((pane, j) => {
    if (!visible[j]) return;
    const span = common(waves, j);
    waves.forEach(({ title, t, panes, bands, marks }, k) => {
      columns[k].append(make("div", pane.label, { class: "soft" }));
      plots.push(plot(columns[k], { label: `${pane.label}, ${title}`, xLabel: j === last ? "time [s]" : "", x: t, curves: panes[j].curves, span, sync: place.id, ...named(bands, marks, j === 0) }));
    });
  });
}

function drawCurves(place) {
  const panel = data.curves[place.dataset.curves];
  clear(place).push(plot(place, panel));
}

function clear(place) {
  for (const u of drawn.get(place) ?? []) u.destroy();
  place.replaceChildren();
  drawn.set(place, []);
  return drawn.get(place);
}

function drawAll() {
  for (const place of document.querySelectorAll(".waves[data-case]")) drawWaves(place);
  for (const place of document.querySelectorAll("[data-curves]")) drawCurves(place);
}

for (const button of document.querySelectorAll("button[data-show]")) {
  button.addEventListener("click", () => {
    const place = document.querySelector(".waves");
    place.dataset.case = button.dataset.show;
    for (const other of document.querySelectorAll("button[data-show]")) other.ariaPressed = other === button;
    drawWaves(place);
    place.scrollIntoView({ block: "nearest", behavior: "smooth" });
  });
}
document.getElementById("more")?.addEventListener("change", () => drawWaves(document.querySelector(".waves")));
document.getElementById("whole")?.addEventListener("click", () => drawWaves(document.querySelector(".waves")));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
addEventListener("resize", () => {
  for (const plots of drawn.values()) for (const u of plots) u.setSize({ width: Math.max(u.root.parentElement.clientWidth, 200), height: HEIGHT });
});
drawAll();
