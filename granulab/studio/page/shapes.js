// Shapes of particles: drawn on a grid, or from a photograph or a drawing with their error.

import { address, order, send } from "./api.js";
import { confirmed, h, opened, put, refusal } from "./dom.js";
import { area, Outline } from "./outline.js";
import { Plane } from "./plane.js";

const PICTURES = /\.(png|jpe?g|tiff?|bmp|webp)$/i;

function field(label, input, words) {
  return h("div", { class: "field" }, h("label", {}, label, input), words ? h("p", {}, words) : null);
}

/** Saves by an order that may find another file of the name; the file, or null. */
async function saved(name, body, said) {
  try {
    let done = await order(name, body);
    if (done.exists && (await confirmed(`${done.file} is there already and holds other shapes.`, "Replace it"))) {
      done = await order(name, { ...body, replace: true });
    }
    return done.exists ? null : done.file;
  } catch (error) {
    put(said, refusal(error.message));
    return null;
  }
}

/** A dialog in which particles are drawn; taken: gets the name of the shape file. */
export function drawnShapes(taken) {
  const stage = h("div", { class: "stage" });
  const name = h("input", { value: "drawn" });
  const radius = h("input", { value: "1 mm" });
  const list = h("ul", { class: "list" });
  const said = h("div");
  const shapes = [];
  let added = 0;
  const keep = h("button", { disabled: true, onclick: async () => {
    const shape = { name: `${added + 1}`, outline: outline.points.map((point) => [...point]) };
    try {
      await order("draw_shapes", { name: "", spheroradius: radius.value, shapes: [shape] });
    } catch (error) {
      put(said, refusal(error.message));
      return;
    }
    put(said);
    shapes.push(shape);
    added += 1;
    outline.past = [];
    outline.set([], false);
    refresh();
  } }, "Add this shape");
  const save = h("button", { class: "main", disabled: true, onclick: async () => {
    const body = { name: name.value, spheroradius: radius.value, shapes };
    const file = await saved("draw_shapes", body, said);
    if (!file) return;
    dialog.close();
    taken(file);
  } }, "Save and use");
  function refresh() {
    put(list, shapes.map((shape, k) => h("li", {}, h("span", {},
      `${shape.name}: ${shape.outline.length} corners, ${Math.abs(area(shape.outline)).toFixed(1)} mm\u00b2 `),
    h("button", { "aria-label": `Leave out shape ${shape.name}`, onclick: () => { shapes.splice(k, 1); refresh(); } }, "\u00d7"))));
    keep.disabled = !outline.closed;
    save.disabled = !shapes.length;
  }
  const loss = () => (shapes.length || outline.points.length ? "The shapes that are drawn here are not saved." : "");
  const dialog = opened("Draw particles", loss, h("p", { class: "quiet" },
    "Outer corners, convex, on a grid of 1 mm; the first corner again closes a shape. Corners are rounded by the "
    + "spheroradius. Drag corners to move them."), stage,
  h("div", { class: "buttons" }, h("button", { onclick: () => outline.undo() }, "Undo"),
    h("button", { onclick: () => outline.clear() }, "Clear"), keep),
  list, field("Spheroradius", radius), field("Name of the shape file", name), said,
  h("div", { class: "buttons" }, save));
  const plane = new Plane(stage);
  plane.canvas.setAttribute("aria-label", "A particle. Arrows move, Enter sets a corner, Delete takes it away.");
  plane.grid = 0.001;
  const outline = new Outline(plane, refresh);
  outline.grid = 0.001;
  outline.activate(true);
  plane.fit([-0.015, 0.015, -0.012, 0.012]);
}

/** A dialog in which particles of a picture or drawing become shapes; taken: gets their file. */
export function importedShapes(taken) {
  let file = null;
  let ends = [];
  const picture = h("div", { class: "picture", hidden: true });
  const image = picture.appendChild(h("img", { alt: "the photograph" }));
  const over = picture.appendChild(h("canvas"));
  const said = h("div");
  const fields = {
    bar: h("input", { placeholder: "such as 20 mm" }),
    scale: h("input", { placeholder: "such as 0.05 mm" }),
    unit: h("input", { placeholder: "as the file says" }),
    spheroradius: h("input", { placeholder: "a tenth of the smallest" }),
    tolerance: h("input", { placeholder: "a fiftieth of their size" }),
  };
  const name = h("input", { value: "" });
  const save = h("button", { class: "main", disabled: true, onclick: async () => {
    const stored = await saved("particles", { ...body(), name: name.value }, said);
    if (!stored) return;
    dialog.close();
    taken(stored);
  } }, "Save and use");
  const bars = field("Length of the scale bar", fields.bar,
    "A straight bar in the picture. It is found by itself; or click its two ends.");
  const scales = field("or length of a pixel", fields.scale);
  const units = field("Unit of the drawing", fields.unit);

  function body() {
    const given = Object.fromEntries(Object.entries(fields).map(([key, input]) => [key, input.value.trim()]));
    return { file, ...given, ...(ends.length === 2 ? { bar_at: ends.flat() } : {}) };
  }
  async function look() {
    if (!file) return;
    try {
      const found = await order("particles", body());
      put(said, h("pre", {}, found.lines.join("\n")), drawing(found));
      if (found.size) drawOver(over, found, ends);
      save.disabled = false;
    } catch (error) {
      put(said, refusal(error.message));
      save.disabled = true;
    }
  }
  const input = h("input", { type: "file", accept: ".png,.jpg,.jpeg,.tif,.tiff,.bmp,.webp,.svg,.dxf", onchange: async () => {
    try {
      file = await send(input.files[0]);
    } catch (error) {
      put(said, refusal(error.message));
      return;
    }
    const photographed = PICTURES.test(file);
    ends = [];
    name.value = file.replace(/\.[^.]*$/, "");
    picture.hidden = bars.hidden = scales.hidden = !photographed;
    units.hidden = photographed;
    if (photographed) image.src = address(file);
    over.width = over.width;
    if (!photographed || fields.bar.value || fields.scale.value) look();
  } });
  over.addEventListener("click", (event) => {
    const part = image.naturalWidth / over.clientWidth;
    ends = ends.length === 2 ? [] : ends;
    ends.push([event.offsetX * part, event.offsetY * part]);
    drawOver(over, { size: [image.naturalWidth, image.naturalHeight] }, ends);
    if (ends.length === 2 && fields.bar.value) look();
  });
  for (const one of Object.values(fields)) one.addEventListener("change", look);
  const dialog = opened("Particles from a photograph or a drawing", () => "", h("p", { class: "quiet" },
    "A picture of particles that lie apart on an even background, with a scale bar; or an SVG or DXF whose closed "
    + "curves are particles."), h("div", { class: "drop" }, input), picture, bars, scales, units,
  field("Spheroradius", fields.spheroradius), field("Tolerance", fields.tolerance), said,
  field("Name of the shape file", name), h("div", { class: "buttons" }, save,
    h("button", { onclick: look }, "Look again")));
  bars.hidden = scales.hidden = units.hidden = true;
}

/** Outlines and bar over a photograph. */
function drawOver(canvas, { size, outlines = [], rounded = [], scale_m: scale, bar }, ends) {
  const [width, height] = size;
  Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d");
  context.lineWidth = Math.max(1, width / 500);
  for (const [set, colour] of [[outlines, "#d55e00"], [rounded, "#0072b2"]]) {
    context.strokeStyle = colour;
    for (const points of set) {
      context.beginPath();
      points.forEach(([x, y], k) => context[k ? "lineTo" : "moveTo"](x / scale, height - y / scale));
      context.closePath();
      context.stroke();
    }
  }
  const at = bar ? [bar.slice(0, 2), bar.slice(2)] : ends;
  context.strokeStyle = context.fillStyle = "#cc2277";
  context.lineWidth *= 2;
  if (at.length === 2) {
    context.beginPath();
    context.moveTo(...at[0]);
    context.lineTo(...at[1]);
    context.stroke();
  }
  for (const [x, y] of at) {
    context.beginPath();
    context.arc(x, y, 2 * context.lineWidth, 0, 2 * Math.PI);
    context.fill();
  }
}

/** Outlines of a drawing under the shapes that they become. */
function drawing({ size, outlines, rounded }) {
  if (size) return null;
  const stage = h("div", { class: "stage" });
  const plane = new Plane(stage);
  const all = outlines.flat();
  const [xs, ys] = [all.map(([x]) => x), all.map(([, y]) => y)];
  plane.layers.push(() => {
    for (const [set, colour, width] of [[outlines, "line", 3], [rounded, "accent", 1.2]]) {
      for (const points of set) {
        plane.trace(points, true);
        plane.context.strokeStyle = plane.colour(colour);
        plane.context.lineWidth = width;
        plane.context.stroke();
      }
    }
  });
  plane.fit([Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)]);
  return stage;
}
