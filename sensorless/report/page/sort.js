// Tables: a heading sorts by its column, first the largest value on top, then the smallest.

function sortBy(table, column, heading) {
  const down = heading.getAttribute("aria-sort") !== "descending";
  for (const th of table.tHead.rows[0].cells) if (th.ariaSort) th.ariaSort = "none";
  heading.ariaSort = down ? "descending" : "ascending";
  const value = (row) => {
    const cell = row.cells[column];
    const number = parseFloat(cell.dataset.v ?? "");
    return Number.isNaN(number) ? (cell.dataset.v === undefined ? cell.textContent.trim() : null) : number;
  };
  const rows = [...table.tBodies[0].rows].map((row) => [value(row), row]);
  rows.sort(([a], [b]) => {
    if (a === null || b === null) return (a === null) - (b === null); // no number: at the end
    const order = typeof a === "number" ? a - b : String(a).localeCompare(String(b));
    return down ? -order : order;
  });
  table.tBodies[0].append(...rows.map(([, row]) => row));
}

for (const table of document.querySelectorAll("table.sortable")) {
  [...table.tHead.rows[0].cells].forEach((heading, column) => {
    heading.querySelector("button")?.addEventListener("click", () => sortBy(table, column, heading));
  });
}
