// Maps: coloured cells, a cross where lock is lost, the value under the pointer.

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
    g.fillStyle = value === -2 ? "#b3151f" : value === -1 ? "#9aa0a6" : shade(value / map.factor / map.most);
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

function drawMap(place, map) {
  const canvas = make("canvas", "", { role: "img", "aria-label": `${map.title}: ${map.y[2]} over ${map.x[2]}` });
  canvas.width = map.columns * CELL;
  canvas.height = map.rows * CELL;
  canvas.style.aspectRatio = "1.25";
  paint(canvas.getContext("2d"), map);
  const across = make("p");
  across.append(make("span", short(map.x[0])), make("span", map.x[2]), make("span", short(map.x[1])));
  const up = make("p");
  up.append(make("span", `↑ ${map.y[2]}, ${short(map.y[0])} to ${short(map.y[1])}`));
  const said = make("output");
  const value = (axis, n, j) => short(axis[0] + ((axis[1] - axis[0]) * j) / Math.max(n - 1, 1));
  canvas.addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect();
    const cell = (x, size, n) => Math.min(Math.max(Math.floor((x / size) * n), 0), n - 1);
    const column = cell(event.clientX - box.left, box.width, map.columns);
    const row = map.rows - 1 - cell(event.clientY - box.top, box.height, map.rows);
    const here = map.values[row * map.columns + column];
    const text = here === -2 ? "lost" : here === -1 ? "beyond the machine" : `${here / map.factor}${map.unit}`;
    said.textContent = `${value(map.x, map.columns, column)}, ${value(map.y, map.rows, row)}: ${text}`;
  });
  canvas.addEventListener("pointerleave", () => (said.textContent = ""));
  place.append(make("h4", map.title), make("p", map.note), up, canvas, across, said);
}

for (const place of document.querySelectorAll(".map")) drawMap(place, data.maps[place.dataset.map]);
for (const bar of document.querySelectorAll(".key i.bar")) bar.style.background = `linear-gradient(to right, ${STOPS})`;
