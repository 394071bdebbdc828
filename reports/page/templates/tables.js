// Tables: sort by a click on a head, "more" opens the other columns.
// A row's place in a column: data-value where the text is no plain number; what is missing goes last.
function value(row, column) {
  const cell = row.cells[column];
  const text = cell.dataset.value ?? cell.textContent.trim();
  if (text === "" || text === "-" || text === "–" || text === "nan") return null;
  const number = text === "inf" ? Infinity : Number(text);
  return Number.isNaN(number) ? text.toLowerCase() : number;
}

function sort(table, column, down) {
  const body = table.tBodies[0];
  const rows = [...body.rows].map((row) => [value(row, column), row]);
  rows.sort(([a], [b]) => {
    if (a === null || b === null) return (a === null) - (b === null);
    const order = a < b ? -1 : Number(a > b);
    return down ? -order : order;
  });
  body.append(...rows.map(([, row]) => row));
}

for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[table.tHead.rows.length - 1].cells];
  heads.forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => {
      const before = head.getAttribute("aria-sort");
      const numbers = !head.classList.contains("name");
      const down = before ? before === "ascending" : numbers;
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      sort(table, column, down);
    });
  });
}

function showAll(button, all) {
  document.getElementById(button.getAttribute("aria-controls")).classList.toggle("all", all);
  button.setAttribute("aria-expanded", String(all));
  button.textContent = all ? "Fewer columns" : `${button.dataset.more} more columns`;
}
const mores = [...document.querySelectorAll(".more")];
for (const button of mores) {
  button.addEventListener("click", () => showAll(button, button.getAttribute("aria-expanded") !== "true"));
}

// Laid out as cards a table is no table for readers who do not see it: its roles are said, and each
// cell has its column's heading with it.
const ROLES = { TABLE: "table", THEAD: "rowgroup", TBODY: "rowgroup", TFOOT: "rowgroup", TR: "row", TD: "cell" };
for (const table of document.querySelectorAll(".as-cards")) {
  for (const part of [table, ...table.querySelectorAll("thead, tbody, tfoot, tr, th, td")]) {
    const head = part.getAttribute("scope") === "row" ? "rowheader" : "columnheader";
    part.setAttribute("role", ROLES[part.tagName] ?? head);
  }
  const heads = [...table.tHead.rows[table.tHead.rows.length - 1].cells];
  for (const cell of table.querySelectorAll("td:not([data-label])")) {
    cell.dataset.label = heads[cell.cellIndex]?.textContent ?? "";
  }
}

// Paper has all columns.
const opened = new Set();
addEventListener("beforeprint", () => {
  for (const button of mores.filter((b) => b.getAttribute("aria-expanded") !== "true")) {
    opened.add(button);
    showAll(button, true);
  }
});
addEventListener("afterprint", () => {
  for (const button of opened) showAll(button, false);
  opened.clear();
});
