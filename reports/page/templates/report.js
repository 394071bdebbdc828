// A row's place in a column: data-value where the text is no plain number; what is missing goes last.
function value(row, column) {
  const cell = row.cells[column];
  const text = cell.dataset.value ?? cell.textContent.trim();
  if (text === "" || text === "-" || text === "nan") return null;
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

function openTarget() {
  const place = location.hash && document.getElementById(location.hash.slice(1));
  const details = place && place.querySelector(":scope > details");
  if (details) { details.open = true; place.scrollIntoView(); }
}
addEventListener("hashchange", openTarget);
openTarget();
