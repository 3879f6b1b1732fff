// Maps: coloured cells, a cross where lock is lost; values by pointer, arrow keys, or as a table.

const STOPS = ["#fdea45", "#d9c55c", "#b1a570", "#8d8878", "#6c6e72", "#4f576c", "#2f406d", "#00224e"];
const CELL = 9; // dots of the picture

function shade(share) {
  const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
  const low = Math.min(Math.floor(at), STOPS.length - 2);
  const part = (hex, j) => parseInt(hex.slice(1 + 2 * j, 3 + 2 * j), 16);
  const mix = (j) => Math.round(part(STOPS[low], j) + (at - low) * (part(STOPS[low + 1], j) - part(STOPS[low], j)));
  return `rgb(${mix(0)} ${mix(1)} ${mix(2)})`;
}

function make(tag, text = "", attributes = {}) {
  const e = document.createElement(tag);
  e.textContent = text;
  for (const [name, value] of Object.entries(attributes)) e.setAttribute(name, value);
  return e;
}

function paint(g, map) {
  map.values.forEach((value, j) => {
    const x = (j % map.columns) * CELL;
    const y = (map.rows - 1 - Math.floor(j / map.columns)) * CELL;
    const share = value / map.factor / map.most;
    g.fillStyle = value === -2 ? "#b3151f" : value === -1 ? "#9aa0a6" : shade(map.light === "most" ? 1 - share : share);
    g.fillRect(x, y, CELL, CELL);
    if (value !== -2) return;
    g.strokeStyle = "#ffffff";
    g.beginPath();
    g.moveTo(x + 2, y + 2);
    g.lineTo(x + CELL - 2, y + CELL - 2);
    g.moveTo(x + CELL - 2, y + 2);
    g.lineTo(x + 2, y + CELL - 2);
    g.stroke();
  });
}

const short = (x) => String(Number(x.toPrecision(3))).replace("-", "−");

const at = (axis, n, j) => short(axis[0] + ((axis[1] - axis[0]) * j) / Math.max(n - 1, 1));

function cellText(map, column, row) {
  const value = map.values[row * map.columns + column];
  return value === -2 ? "lost" : value === -1 ? "beyond the machine" : `${value / map.factor}${map.unit}`;
}

function tableOf(map) {
  const table = make("table");
  table.createCaption().textContent = `across: ${map.x[2]}; down: ${map.y[2]}`;
  const head = table.createTHead().insertRow();
  head.append(make("td"));
  for (let j = 0; j < map.columns; j++) head.append(make("th", at(map.x, map.columns, j), { scope: "col" }));
  const body = table.createTBody();
  for (let row = map.rows - 1; row >= 0; row--) {
    const line = body.insertRow();
    line.append(make("th", at(map.y, map.rows, row), { scope: "row" }));
    for (let j = 0; j < map.columns; j++) line.append(make("td", cellText(map, j, row)));
  }
  return table;
}

// Tells the cell under the pointer, or the one that the arrow keys move to.
function listen(canvas, map, said) {
  const here = { column: Math.floor(map.columns / 2), row: Math.floor(map.rows / 2) };
  const within = (j, n) => Math.min(Math.max(j, 0), n - 1);
  const g = canvas.getContext("2d");
  const go = (column, row, mark) => {
    here.column = within(column, map.columns);
    here.row = within(row, map.rows);
    said.textContent = `${at(map.x, map.columns, here.column)}, ${at(map.y, map.rows, here.row)}: ${cellText(map, here.column, here.row)}`;
    paint(g, map);
    if (!mark) return;
    const corner = [here.column * CELL, (map.rows - 1 - here.row) * CELL];
    for (const [colour, inset] of [["#000000", 0.5], ["#ffffff", 1.5]]) {
      g.strokeStyle = colour;
      g.strokeRect(corner[0] + inset, corner[1] + inset, CELL - 2 * inset, CELL - 2 * inset);
    }
  };
  const point = (event) => {
    const box = canvas.getBoundingClientRect();
    const share = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    go(Math.floor(share[0] * map.columns), map.rows - 1 - Math.floor(share[1] * map.rows), event.pointerType === "touch");
  };
  const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  for (const kind of ["pointermove", "pointerdown"]) canvas.addEventListener(kind, point);
  canvas.addEventListener("pointerleave", (event) => {
    if (event.pointerType !== "touch" && document.activeElement !== canvas) said.textContent = "";
  });
  canvas.addEventListener("focus", () => canvas.matches(":focus-visible") && go(here.column, here.row, true));
  canvas.addEventListener("blur", () => ((said.textContent = ""), paint(g, map)));
  canvas.addEventListener("keydown", (event) => {
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    go(here.column + step[0], here.row + step[1], true);
  });
}

function drawMap(place, map) {
  const label = `${map.title}: ${map.y[2]} over ${map.x[2]}, ${map.note}; arrow keys read the values`;
  const canvas = make("canvas", "", { role: "application", "aria-roledescription": "map", "aria-label": label, tabindex: "0" });
  canvas.width = map.columns * CELL;
  canvas.height = map.rows * CELL;
  canvas.style.aspectRatio = "1.25";
  paint(canvas.getContext("2d"), map);
  const across = make("p");
  across.append(make("span", short(map.x[0])), make("span", map.x[2]), make("span", short(map.x[1])));
  const up = make("p");
  up.append(make("span", `↑ ${map.y[2]}, ${short(map.y[0])} to ${short(map.y[1])}`));
  const said = make("output");
  listen(canvas, map, said);
  const values = make("details", "", { class: "screen" });
  const scroll = make("div", "", { class: "scroll", tabindex: "0", role: "region", "aria-label": `values of ${map.title}` });
  values.append(make("summary", "values"), scroll);
  values.addEventListener("toggle", () => scroll.children.length || scroll.append(tableOf(map)));
  place.append(make("h4", map.title), make("p", map.note), up, canvas, across, said, values);
}

for (const place of document.querySelectorAll(".map")) drawMap(place, data.maps[place.dataset.map]);
for (const bar of document.querySelectorAll(".key i.bar")) bar.style.background = `linear-gradient(to right, ${STOPS})`;
