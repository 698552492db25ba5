// A table that can be sorted by a click on a column and filtered by text.

const ROWS_AT_FIRST = 200;
// Tables up to this number of rows have no filter.
const FEW_ROWS = 8;
const words = new Intl.Collator("en", { numeric: true });

// Numbers come before text, and empty cells last in both directions.
const compare = (a, b, direction) => {
  if (a === null || b === null) return (a === null) - (b === null);
  if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;
  return direction * (typeof a === "number" ? a - b : words.compare(a, b));
};

const cellText = (value) => {
  if (value === null) return "";
  if (typeof value === "string") return value;
  const x = Number.isInteger(value) ? value : Number(value.toPrecision(5));
  const size = Math.abs(x);
  const plain = String(x);
  if (x === 0 || (size >= 1e-3 && size < 1e5)) return plain;
  const power = x.toExponential().replace("e+", "e");
  return power.length < plain.length ? power : plain;
};
// A text with more characters is wrapped.
const LONG = 36;

class SortTable {
  constructor({ title, file, columns, rows, failed, all }) {
    const failures = new Set(failed);
    this.columns = columns;
    this.rows = rows.map((cells, i) => {
      const texts = cells.map(cellText);
      return { cells, texts, found: texts.join(" ").toLowerCase(), failed: failures.has(i), tr: null };
    });
    // Columns of text are left-aligned.
    this.worded = columns.map((_, i) => rows.some((row) => typeof row[i] === "string"));
    this.shown = this.rows;
    this.column = -1;
    this.direction = 1;
    this.most = ROWS_AT_FIRST;
    this.filter = element("input", "filter");
    Object.assign(this.filter, { type: "search", placeholder: "Filter by words", spellcheck: false });
    this.filter.setAttribute("aria-label", `filter the rows of ${title}`);
    this.filter.addEventListener("input", () => this.choose());
    this.count = element("span", "hint");
    this.failures = button("Failures", "show failures alone", () => {
      const on = this.failures.classList.toggle("on");
      this.failures.setAttribute("aria-pressed", String(on));
      this.choose();
    });
    this.more = button("Show more rows", "show more rows", () => { this.most *= 5; this.draw(); });
    this.heads = columns.map((name, i) => {
      const head = element("th", this.worded[i] ? "worded" : "", "", [button(name, `sort by ${name}`, () => this.sortBy(i))]);
      head.scope = "col";
      return head;
    });
    this.body = element("tbody");
    const tools = [this.filter, this.count];
    if (failures.size) tools.splice(1, 0, this.failures);
    const few = rows.length <= FEW_ROWS;
    const parts = [
      ...(few ? [] : [element("div", "tools", "", tools)]),
      element("div", "scroll", "", [element("table", "sorted", "", [element("thead", "", "", [element("tr", "", "", this.heads)]), this.body])]),
      this.more,
    ];
    const cut = all > rows.length ? `The first ${rows.length} of ${all} rows` : "";
    const source = file && (cut ? `all are in ${file}` : `The same rows are in ${file}`);
    const told = [cut, source].filter(Boolean).join("; ");
    if (told) parts.push(element("p", "hint", `${told}.`));
    this.root = panel(title, parts);
    this.root.dataset.title = title;
    this.choose();
  }

  sortBy(column) {
    this.direction = this.column === column ? -this.direction : 1;
    this.column = column;
    this.heads.forEach((head, i) => {
      if (i === column) head.setAttribute("aria-sort", this.direction > 0 ? "ascending" : "descending");
      else head.removeAttribute("aria-sort");
    });
    this.choose();
  }

  // The rows with all words of the filter, in order.
  choose() {
    const wanted = this.filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    const failed = this.failures.classList.contains("on");
    this.shown = this.rows.filter((row) => wanted.every((word) => row.found.includes(word)) && (row.failed || !failed));
    const { column, direction } = this;
    if (column >= 0) this.shown.sort((a, b) => compare(a.cells[column], b.cells[column], direction));
    const all = this.rows.length;
    this.count.textContent = this.shown.length === all ? `${all} rows` : `${this.shown.length} of ${all} rows`;
    this.draw();
  }

  draw() {
    this.body.replaceChildren(...this.shown.slice(0, this.most).map((row) => {
      row.tr ??= element("tr", row.failed ? "failed" : "", "", row.texts.map((text, i) => element("td", (this.worded[i] ? "worded" : "") + (text.length > LONG ? " long" : ""), text)));
      return row.tr;
    }));
    this.more.hidden = this.shown.length <= this.most;
  }
}
