"use strict";
// A click on a head sorts its table by that column: by number where the cells begin with one.
(() => {
  const number = /^[-−+]?\d[\d.]*(?:e[-+]?\d+)?/i;

  function key(row, column) {
    const text = row.cells[column].textContent.trim();
    const found = text.replace(/^[<≤≥>~]\s*/, "").match(number);
    return { text, value: found ? Number(found[0].replace("−", "-")) : NaN };
  }

  function order(a, b, sign) {
    const [one, other] = [Number.isNaN(a.value), Number.isNaN(b.value)];
    if (one !== other) return one ? 1 : -1; // dashes and words come last, either way
    return sign * (one ? a.text.localeCompare(b.text) : a.value - b.value);
  }

  function sort(table, column, head) {
    const down = head.getAttribute("aria-sort") === "ascending";
    for (const other of head.parentNode.cells) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const body = table.tBodies[0];
    const rows = [...body.rows].map((row) => [key(row, column), row]);
    rows.sort((a, b) => order(a[0], b[0], down ? -1 : 1));
    body.append(...rows.map((entry) => entry[1]));
  }

  for (const table of document.querySelectorAll("table")) {
    for (const [column, head] of [...(table.tHead?.rows[0].cells ?? [])].entries()) {
      head.tabIndex = 0;
      head.addEventListener("click", () => sort(table, column, head));
      head.addEventListener("keydown", (event) => {
        if (event.key === "Enter") sort(table, column, head);
      });
    }
  }
})();
