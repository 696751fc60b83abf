// The page of many runs: tables to sort, a plot of any two columns, a link to the page of each run.

import { readData } from "./data.js";
import { Points } from "./points.js";
import { digits } from "./scale.js";

/**
 * A table: title, columns, rows of values, links (an address or null, of each row), key columns that
 * are shown at first and those that the plot begins with.
 */
class Table {
  constructor(section, spec) {
    Object.assign(this, { spec, all: false, by: -1, falling: false });
    this.order = spec.rows.map((_, k) => k);
    section.append(heading(spec));
    this.toggle = section.appendChild(document.createElement("button"));
    this.toggle.type = "button";
    this.toggle.addEventListener("click", () => {
      this.all = !this.all;
      this.draw();
    });
    this.toggle.hidden = spec.key.length === spec.columns.length;
    const wide = section.appendChild(document.createElement("div"));
    wide.className = "wide";
    wide.tabIndex = 0;
    this.table = wide.appendChild(document.createElement("table"));
    this.draw();
  }

  sort(column) {
    this.falling = this.by === column && !this.falling;
    this.by = column;
    const { rows } = this.spec, sign = this.falling ? -1 : 1;
    this.order.sort((a, b) => sign * compared(worth(rows[a][column]), worth(rows[b][column])) || a - b);
    this.draw();
  }

  draw() {
    const { spec } = this;
    const shown = spec.columns.map((_, k) => k).filter((k) => this.all || spec.key.includes(k));
    this.toggle.textContent = this.all ? "Fewer columns" : `All ${spec.columns.length} columns`;
    const head = document.createElement("tr");
    head.append(document.createElement("td"));
    for (const k of shown) head.append(this.headOf(k));
    const body = this.order.map((row) => this.rowOf(row, shown));
    this.table.replaceChildren(head, ...body);
  }

  headOf(column) {
    const cell = document.createElement("th");
    cell.scope = "col";
    if (column === this.by) cell.ariaSort = this.falling ? "descending" : "ascending";
    const button = cell.appendChild(document.createElement("button"));
    button.type = "button";
    button.textContent = this.spec.columns[column];
    button.addEventListener("click", () => this.sort(column));
    return cell;
  }

  rowOf(row, shown) {
    const { spec } = this, line = document.createElement("tr");
    const first = line.appendChild(document.createElement("td"));
    first.append(this.opener(line, row));
    if (spec.links?.[row]) {
      const link = first.appendChild(document.createElement("a"));
      link.href = spec.links[row];
      link.textContent = "play";
    }
    if (spec.folders?.[row]) {
      const link = first.appendChild(document.createElement("a"));
      link.href = spec.folders[row];
      link.textContent = "files";
    }
    for (const column of shown) {
      const cell = line.appendChild(document.createElement("td"));
      const value = spec.rows[row][column];
      cell.textContent = inWords(value);
      if (typeof worth(value) === "number") cell.className = "number";
    }
    return line;
  }

  /** A button that shows all that is known of a row below it. */
  opener(line, row) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = "+";
    button.ariaLabel = "All numbers of this row";
    button.ariaExpanded = "false";
    let below = null;
    button.addEventListener("click", () => {
      if (below) below.remove();
      below = below ? null : this.detailsOf(row, line.cells.length);
      if (below) line.after(below);
      button.textContent = below ? "\u2212" : "+";
      button.ariaExpanded = String(Boolean(below));
    });
    return button;
  }

  detailsOf(row, wide) {
    const line = document.createElement("tr"), cell = line.appendChild(document.createElement("td"));
    cell.colSpan = wide;
    const list = cell.appendChild(document.createElement("dl"));
    this.spec.columns.forEach((name, k) => {
      const value = this.spec.rows[row][k];
      if (value === null || value === "") return;
      list.append(document.createElement("dt"), document.createElement("dd"));
      list.lastChild.previousSibling.textContent = name;
      list.lastChild.textContent = inWords(value);
    });
    return line;
  }
}

function heading({ title, note }) {
  const part = document.createDocumentFragment();
  part.append(document.createElement("h2"), document.createElement("p"));
  part.firstChild.textContent = title;
  part.lastChild.textContent = note;
  part.lastChild.className = "note";
  return part;
}

function inWords(value) {
  if (value === null) return "–";
  if (value.words !== undefined) return value.words;
  if (typeof value === "number") return Number.isInteger(value) ? `${value}` : digits(value);
  return Array.isArray(value) ? value.map(inWords).join(" ") : `${value}`;
}

/** What a cell is sorted by: its value; of words, the number that stands behind them. */
const worth = (cell) => (cell?.words === undefined ? cell : cell.by);

/** Order of two cells: numbers by size, texts by letters, nothing last. */
function compared(a, b) {
  if (a === null || b === null) return (a === null) - (b === null);
  if (typeof a === "number" && typeof b === "number") return a - b;
  return `${a}`.localeCompare(`${b}`, undefined, { numeric: true });
}

function start() {
  const data = readData(), element = (id) => document.getElementById(id);
  element("title").textContent = data.title;
  element("outcome").textContent = data.outcome;
  for (const { name, source } of data.figures) {
    const image = element("figures").appendChild(document.createElement("img"));
    image.alt = name;
    image.src = source;
  }
  const tables = data.tables.map((spec) =>
    new Table(element("tables").appendChild(document.createElement("section")), spec));
  const points = new Points(data.tables.at(-1));
  window.study = { data, tables, points }; // for the console, and for tests
}

start();
