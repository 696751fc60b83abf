// Silos: the outline drawn or imported, particles and materials chosen, what will be poured shown.

import { documents, order, send } from "./api.js";
import { Case } from "./case.js";
import { choices, h, note, put, refusal } from "./dom.js";
import { Outline } from "./outline.js";
import { materialsTable } from "./materials.js";
import { Plane } from "./plane.js";
import { drawnShapes, importedShapes } from "./shapes.js";

const ABOVE = 0.35; // of the silo's height that is shown above it
const FRESH = [-0.3, 0.3, -0.05, 0.6]; // m, where nothing is drawn yet

/** The room of silos. */
export function siloRoom(start, watch) {
  const one = new Case("silo2d", start, watch);
  const stage = h("div", { class: "stage" });
  const plane = new Plane(stage);
  plane.canvas.setAttribute("aria-label", "The silo. While drawing: arrows move, Enter sets a point, Delete takes it away.");
  const outline = new Outline(plane, (kept) => written(one, outline, kept), () => REPLACED.map((key) => one.form.get(`silo.${key}`)));
  const bar = toolbar(one, plane, outline);
  let preview = null;
  plane.layers.unshift(() => drawPreview(plane, preview, outline, bar.poured.checked));
  bar.poured.addEventListener("change", () => plane.draw());
  one.shown = (found) => {
    const before = preview;
    preview = found.preview ?? null;
    bar.unseen.hidden = !preview?.particles || preview.particles.kind.length > 0;
    if (preview && !plane.moved && !outline.active && String(before?.outline) !== String(preview.outline)) {
      plane.fit(around(preview));
    }
    plane.draw();
  };
  one.filled = (texts) => {
    outline.past = [];
    read();
    bar.draw(false);
    plane.moved = false;
  };
  const particles = particlesGroup(one, start);
  const room = h("div", { class: "bench" },
    h("section", { class: "keys" }, one.head(),
      one.form.group("silo", { open: true }), particles,
      one.form.group("fill", { open: true }),
      ["run", "law", "disorder", "pymunk", "output"].map((name) => one.form.group(name))),
    h("section", { class: "drawing" }, bar.element, stage),
    one.side());
  /** Outline and unit as the form has them. */
  function read() {
    const points = measured(one, outline) ? pointsOf(one.form.get("silo.outline")) : null;
    outline.set(points ?? [], Boolean(points));
  }
  for (const key of ["outline", "outline_unit"]) one.form.inputs.get(`silo.${key}`).addEventListener("input", read);
  plane.fit(FRESH);
  one.begin({ name: "silo", silo: { preset: "A4" } });
  return { element: room, enter: () => one.check(0), leave() {}, take: (texts) => one.take(texts) };
}

// Keys in whose place an outline stands, or that go with it, and how long its units are [m].
const REPLACED = ["preset", "angle", "width", "height", "outline", "outline_unit", "outlet", "outlet_centre"];
const UNITS = { um: 1e-6, mm: 1e-3, cm: 1e-2, m: 1 };

/** Gives the outline the unit of the form; false where it is one in which nothing is drawn. */
function measured(one, outline) {
  const unit = one.form.get("silo.outline_unit").trim() || "mm";
  const known = unit in UNITS;
  outline.measure(known ? unit : "mm", known ? UNITS[unit] : UNITS.mm);
  return known;
}

/** Writes the drawn outline into the form, in place of preset and hopper; kept: texts before it. */
function written(one, outline, kept) {
  if (kept) {
    REPLACED.forEach((key, k) => one.form.set(`silo.${key}`, kept[k]));
    measured(one, outline);
  } else {
    for (const key of ["preset", "angle", "width", "height"]) one.form.set(`silo.${key}`, "");
    one.form.set("silo.outline", JSON.stringify(outline.points).replaceAll(",", ", "));
    if (!measured(one, outline)) one.form.set("silo.outline_unit", "");
  }
  one.check();
}

function pointsOf(text) {
  try {
    const points = JSON.parse(text);
    return Array.isArray(points) && points.every((p) => Array.isArray(p) && p.length === 2) ? points : null;
  } catch {
    return null;
  }
}

function toolbar(one, plane, outline) {
  const drawing = h("button", { "aria-pressed": "false", onclick: () => draw(!outline.active) }, "Draw the outline");
  const step = h("select", { "aria-label": "Grid" });
  choices(step, [["", [["50", "grid 50 mm"], ["10", "grid 10 mm"], ["5", "grid 5 mm"], ["1", "grid 1 mm"]]]], "10");
  step.addEventListener("change", () => { outline.grid = plane.grid = Number(step.value) / 1000; plane.draw(); });
  plane.grid = 0.01;
  const poured = h("input", { type: "checkbox", checked: true });
  const unseen = h("span", { class: "quiet", hidden: true }, "(too many to draw)");
  const hint = h("p", { class: "quiet", role: "status" });
  function draw(active) {
    outline.activate(active);
    drawing.setAttribute("aria-pressed", String(active));
    if (active && outline.closed === false && outline.points.length === 0) plane.fit(FRESH);
    put(hint, active
      ? "Click the corners of the inside, and the first one again at the end. Drag a corner to move it; click an "
        + "edge to add one. The lowest edge holds the outlet, the highest is the open top."
      : "Drag to move, wheel to enlarge.");
  }
  const unit = h("input", { "aria-label": "Unit of a drawing that does not say it", placeholder: "unit", size: "3" });
  const file = h("input", {
    type: "file", accept: ".svg,.dxf", hidden: true, onchange: () => imported(one, plane, outline, file, unit.value, draw),
  });
  draw(false);
  const element = h("div", {},
    h("div", { class: "buttons" }, drawing, step,
      h("button", { onclick: () => outline.undo() }, "Undo"),
      h("button", { onclick: () => { outline.clear(); draw(true); } }, "Clear"),
      h("button", { onclick: () => file.click() }, "Import SVG or DXF"), unit, file,
      h("button", { onclick: () => plane.zoom(1.3), "aria-label": "Enlarge" }, "+"),
      h("button", { onclick: () => plane.zoom(1 / 1.3), "aria-label": "Make smaller" }, "\u2212"),
      h("button", { onclick: () => plane.fit() }, "Whole"),
      h("label", {}, poured, "as poured ", unseen)), hint);
  return { element, poured, unseen, draw };
}

async function imported(one, plane, outline, input, unit, draw) {
  const [file] = input.files;
  input.value = "";
  if (!file) return;
  try {
    const name = await send(file);
    const found = await order("outline", { file: name, unit });
    outline.remember();
    const factor = UNITS.mm / outline.unit;
    outline.set(found.outline.map((point) => point.map((value) => Number((factor * value).toPrecision(12)))));
    draw(false);
    plane.moved = false;
    for (const key of ["outlet", "outlet_centre"]) one.form.set(`silo.${key}`, found[key] ?? "");
    written(one, outline);
    note(`${found.outline.length} corners from ${name}`);
  } catch (error) {
    put(one.verdict, refusal(error.message));
  }
}

function around({ outline }) {
  const [xs, ys] = [outline.map(([x]) => x), outline.map(([, y]) => y)];
  const [left, right, bottom, top] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  return [left, right, bottom - 0.06 * (top - bottom), top + ABOVE * (top - bottom)];
}

/** The silo and its particles before they fall. An outline that is being drawn has its own place. */
function drawPreview(plane, preview, outline, poured) {
  if (!preview) return;
  const { context } = plane;
  const at = outline.active || outline.points.length ? drawnAt(preview, outline) : [0, 0];
  if (preview.particles && poured && (!outline.active || outline.closed)) {
    const pose = preview.particles.pose.map(([x, y, angle]) => [x + at[0], y + at[1], angle]);
    plane.particles({ kind: preview.particles.kind, pose }, preview.shapes);
  }
  const corners = preview.outline.map(([x, y]) => [x + at[0], y + at[1]]);
  const top = Math.max(...corners.map(([, y]) => y));
  context.strokeStyle = plane.colour("wall");
  context.lineWidth = 2.5;
  corners.forEach((corner, k) => {
    const next = corners[(k + 1) % corners.length];
    if (corner[1] === top && next[1] === top) return;
    plane.trace([corner, next], false);
    context.stroke();
  });
  const level = preview.level + at[1];
  const [left, right] = [Math.min(...corners.map(([x]) => x)), Math.max(...corners.map(([x]) => x))];
  plane.trace(preview.particles ? [[left, level], [right, level]] : [], false);
  context.setLineDash([6, 5]);
  context.lineWidth = 1;
  context.strokeStyle = plane.colour("quiet");
  context.stroke();
  context.setLineDash([]);
  context.lineWidth = 4;
  context.strokeStyle = plane.colour("line");
  const moved = (points) => points.map(([x, y]) => [x + at[0], y + at[1]]);
  for (const ends of [preview.lips, ...preview.outlets]) {
    plane.trace(moved(ends), false);
    context.stroke();
  }
  context.lineWidth = 2;
  for (const insert of preview.inserts) {
    plane.trace(moved(insert), true);
    context.stroke();
  }
}

/** Where the case's silo, whose lowest edge is at y = 0, lies on the drawing. */
function drawnAt(preview, outline) {
  if (!outline.closed) return [0, 0];
  return [0, outline.unit * Math.min(...outline.points.map(([, y]) => y))];
}

function particlesGroup(one, start) {
  const group = one.form.group("particles", { open: true });
  const box = h("div", { class: "materials" });
  const shapes = h("select", { class: "wide", "aria-label": "Shapes from the catalogue" });
  const tables = h("select", { class: "wide", "aria-label": "Materials tables" });
  one.listed = () => {
    const own = documents(start);
    choices(shapes, [["", [["", "from the catalogue"]]], ["Shipped", start.shapes], ["In the folder", own]]);
    choices(tables, [["", [["", "from the catalogue"]]], ["Shipped", start.materials], ["In the folder", own]]);
  };
  const chosen = (key, value) => { one.form.set(`particles.${key}`, value); one.check(0); };
  shapes.addEventListener("change", () => { chosen("shapes", shapes.value); shapes.value = ""; });
  tables.addEventListener("change", () => { chosen("materials", tables.value); tables.value = ""; });
  const taken = async (file) => {
    await one.lookAgain();
    chosen("shapes", file);
    note(`particles of ${file}`);
  };
  one.listed();
  for (const list of [shapes, tables]) list.addEventListener("focus", () => one.lookAgain());
  const sources = h("details", { ontoggle: () => sources.open && materialsTable(box, one.form.get("particles.materials") || "wood") },
    h("summary", {}, "Materials and their sources"), box);
  group.append(
    h("div", { class: "buttons" }, h("label", {}, "Shapes"), shapes,
      h("button", { onclick: () => drawnShapes(taken) }, "Draw"),
      h("button", { onclick: () => importedShapes(taken) }, "From a photograph or drawing")),
    h("div", { class: "buttons" }, h("label", {}, "Materials"), tables), sources);
  one.form.inputs.get("particles.materials").addEventListener("change", () => { sources.open = false; });
  return group;
}
