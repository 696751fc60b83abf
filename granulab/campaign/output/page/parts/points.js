// A plot of two columns of a table: a point for each row, which leads to the run of the row.

import { rounded } from "./curves.js";
import { digits } from "./scale.js";
import { onThemeChange, readTheme } from "./theme.js";

const LEFT = 62, RIGHT = 14, TOP = 26, BOTTOM = 40; // px round the points
const RADIUS = 5, NEAR = 14; // px of a point, and of the pointer from it
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#e69f00", "#56b4e9", "#cc79a7", "#8a8a8a"];

/** A plot with its selections; table as in study.js. */
export class Points {
  constructor(table) {
    this.table = table;
    this.canvas = document.getElementById("points");
    this.context = this.canvas.getContext("2d");
    this.theme = readTheme();
    const columns = table.columns.map((_, k) => k);
    const numbers = columns.filter((k) => values(table, k).some((v) => typeof v === "number"));
    const few = columns.filter((k) => new Set(values(table, k).map(String)).size <= COLOURS.length);
    this.x = this.select("x", numbers, table.plot.x ?? numbers[0]);
    this.y = this.select("y", numbers, table.plot.y ?? numbers.at(-1));
    this.group = this.select("group", few, table.plot.group, "none");
    this.logarithmic = document.getElementById("logarithmic");
    document.getElementById("plot").hidden = numbers.length < 2;
    this.logarithmic.addEventListener("change", () => this.draw());
    this.canvas.addEventListener("pointermove", (event) => this.point(event));
    this.canvas.addEventListener("click", (event) => this.open(event));
    onThemeChange(() => {
      this.theme = readTheme();
      this.draw();
    });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  select(id, columns, chosen, none) {
    const select = document.getElementById(id);
    const options = columns.map((k) => new Option(this.table.columns[k], k, false, k === chosen));
    select.replaceChildren(...(none ? [new Option(none, -1)] : []), ...options);
    select.value = String(chosen ?? -1);
    select.addEventListener("change", () => this.draw());
    return select;
  }

  draw() {
    const { context, theme } = this, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const { width, height } = this.canvas.getBoundingClientRect();
    Object.assign(this, { width, height });
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    context.scale(ratio, ratio);
    this.rows = this.table.rows.flatMap((row, k) => {
      const [x, y] = [row[this.x.value], row[this.y.value]];
      const fits = typeof x === "number" && typeof y === "number"
        && (!this.logarithmic.checked || x > 0);
      return fits ? [{ k, x: this.logarithmic.checked ? Math.log10(x) : x, y }] : [];
    });
    if (!this.rows.length) return;
    const [x, y] = [this.axis("x", LEFT, width - RIGHT), this.axis("y", height - BOTTOM, TOP)];
    this.drawAxes(x, y);
    const groups = [...new Set(this.rows.map(({ k }) => String(this.groupOf(k))))]
      .sort((a, b) => a.localeCompare(b, undefined, { numeric: true }));
    for (const row of this.rows) {
      row.at = [x.place(row.x), y.place(row.y)];
      const group = groups.indexOf(String(this.groupOf(row.k)));
      context.fillStyle = theme.of(COLOURS[group % COLOURS.length]);
      context.beginPath();
      context.arc(...row.at, RADIUS, 0, 2 * Math.PI);
      context.fill();
    }
    if (this.group.value !== "-1") this.drawGroups(groups);
  }

  groupOf(k) {
    return this.group.value === "-1" ? "" : this.table.rows[k][this.group.value];
  }

  axis(name, from, to) {
    const all = this.rows.map((row) => row[name]);
    const [least, most] = [Math.min(...all), Math.max(...all)];
    const loose = 0.06 * (most - least) || 0.1 * Math.abs(most) || 1;
    const [low, high] = [least - loose, most + loose];
    return { low, high, place: (value) => from + ((value - low) / (high - low)) * (to - from) };
  }

  drawAxes(x, y) {
    const { context, theme } = this;
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = theme.quiet;
    context.strokeStyle = theme.rule;
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const value of rounded(y.low, y.high, 6)) {
      context.beginPath();
      context.moveTo(LEFT, y.place(value));
      context.lineTo(this.width - RIGHT, y.place(value));
      context.stroke();
      context.fillText(digits(value), LEFT - 8, y.place(value));
    }
    context.textAlign = "center";
    context.textBaseline = "alphabetic";
    for (const value of rounded(x.low, x.high, Math.max(2, Math.floor(this.width / 110)))) {
      context.fillText(digits(this.logarithmic.checked ? 10 ** value : value), x.place(value),
        this.height - BOTTOM + 16);
    }
    context.fillStyle = theme.ink;
    context.fillText(this.table.columns[this.x.value], (LEFT + this.width) / 2, this.height - 6);
    context.textAlign = "left";
    context.fillText(this.table.columns[this.y.value], 8, 14);
  }

  drawGroups(groups) {
    const { context, theme } = this, name = this.table.columns[this.group.value];
    let left = LEFT + context.measureText(this.table.columns[this.y.value]).width;
    for (const [text, colour] of [[name, null], ...groups.map((group, k) =>
      [`\u25cf ${group}`, COLOURS[k % COLOURS.length]])]) {
      context.fillStyle = theme.of(colour);
      context.fillText(text, left, 14);
      left += context.measureText(text).width + 12;
    }
  }

  /** The row whose point is nearest to the pointer, or null. */
  nearest(event) {
    const { left, top } = this.canvas.getBoundingClientRect();
    const away = ({ at }) => Math.hypot(event.clientX - left - at[0], event.clientY - top - at[1]);
    const near = (this.rows ?? []).filter((row) => away(row) < NEAR);
    return near.sort((a, b) => away(a) - away(b))[0] ?? null;
  }

  point(event) {
    const row = this.nearest(event), { table } = this;
    this.canvas.classList.toggle("links", Boolean(row && table.links?.[row.k]));
    if (!row) return;
    const words = table.key.map((k) => `${table.columns[k]} ${shown(table.rows[row.k][k])}`);
    document.getElementById("pointed").textContent = words.join(" \u00b7 ");
  }

  open(event) {
    const row = this.nearest(event), link = row && this.table.links?.[row.k];
    if (link) window.location.href = link;
  }
}

function values(table, column) {
  return table.rows.map((row) => row[column]);
}

function shown(value) {
  return typeof value === "number" ? digits(value) : value ?? "–";
}
