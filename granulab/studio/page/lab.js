// The laboratory: a film or table dropped on the page, measured, its value written into a file.

import { address, ask, documents, fresh, send } from "./api.js";
import { choices, h, note, put, refusal } from "./dom.js";
import { kept, Task } from "./task.js";

const FILM = /\.(mp4|m4v|mov|avi|mkv|webm|png|jpe?g|tiff?|bmp|webp)$/i;
const WRITES = ["into", "pair", "material"];

/** The room of measurements. */
export function labRoom(start) {
  const tasks = start.tasks.filter(({ task }) => task.startsWith("calibrate "));
  const which = choices(h("select", { "aria-label": "Measurement" }),
    [["", tasks.map(({ task, meaning }) => [task, `${task.replace("calibrate ", "")}: ${meaning}`])]], tasks[0].task);
  const left = h("section");
  const right = h("section");
  const files = h("ul", { class: "list" });
  const known = kept(h("select", { "aria-label": "Files in the folder" }), start, refreshFiles);
  const materials = h("datalist", { id: "own-materials" });
  let chosen = [];
  let attached = null; // files of an earlier answer, which another measurement does not take over
  let task = null;
  let region = null;

  function refreshFiles() {
    const { text, picture, film, data } = start.files;
    const groups = [["", [["", "a file in the folder"]]], ["Films", film], ["Tables and signals",
      [...text.filter((name) => /\.(csv|txt|tsv)$/i.test(name)), ...data]], ["Pictures", picture]];
    choices(known, groups);
    put(materials, documents(start).map((name) => h("option", { value: name })));
  }
  function refresh() {
    put(files, chosen.map((name) => h("li", {}, h("span", {}, name, " "),
      h("button", { "aria-label": `Leave out ${name}`, onclick: () => { chosen = chosen.filter((one) => one !== name); refresh(); } }, "\u00d7"))));
    const film = chosen.find((name) => FILM.test(name));
    region.show(task.inputs.has("roi") ? film : undefined);
  }
  async function take(list) {
    for (const file of list) {
      try {
        const name = await send(file);
        if (!chosen.includes(name)) chosen = [...chosen, name];
        note(`${name} is in the folder`);
      } catch (error) {
        put(task.said, refusal(error.message));
      }
    }
    await fresh(start, refreshFiles);
    refresh();
  }
  async function choose(name) {
    const form = await ask("task", { task: name });
    if (name !== which.value) return; // another was chosen while this one's form was on its way
    task?.leave();
    task = new Task(name, form, () => chosen);
    task.done = () => fresh(start, refreshFiles);
    if (chosen === attached) chosen = [];
    task.asked = (one) => { attached = chosen = [...one.files]; refresh(); };
    region = new Region((text) => { task.inputs.get("roi").value = text; });
    const measure = h("button", { class: "main", onclick: () => task.start(withoutWriting()) }, "Measure");
    const fields = task.fields((option) => !WRITES.includes(option));
    const first = fields.filter((field) => field.querySelector("#task-roi, #task-fps, #task-scale"));
    const others = fields.filter((field) => !first.includes(field));
    put(left, h("p", { class: "quiet" }, form.meaning), dropZone(take),
      h("div", { class: "buttons" }, h("label", {}, "or"), known), files, h("div", { class: "buttons" }, measure), first,
      others.length ? h("details", {}, h("summary", {}, "Other options"), others) : null, writing(form));
    put(right, region.element, task.output());
    refresh();
    task.attach((one) => !chosen.length || one.files.join("/") === chosen.join("/"));
  }
  function withoutWriting() {
    return Object.fromEntries(WRITES.filter((name) => task.inputs.has(name)).map((name) => [name, ""]));
  }
  function writing(form) {
    const fields = task.fields((option) => WRITES.includes(option));
    if (!fields.length || !form.options.some((option) => option.name === "into")) return null;
    kept(task.inputs.get("into"), start, refreshFiles).setAttribute("list", "own-materials");
    return h("details", {}, h("summary", {}, "Write the value into a materials file"), fields, materials,
      h("div", { class: "buttons" }, h("button", { onclick: () => task.start() }, "Measure and write")));
  }

  known.addEventListener("change", () => {
    if (known.value && !chosen.includes(known.value)) chosen = [...chosen, known.value];
    known.value = "";
    refresh();
  });
  which.addEventListener("change", () => choose(which.value));
  refreshFiles();
  choose(tasks[0].task);
  return {
    element: h("div", { class: "lab" }, h("div", {}, h("div", { class: "buttons" }, which), left), right),
    leave() {},
  };
}

function dropZone(take) {
  const input = h("input", { type: "file", multiple: true, "aria-label": "Film or table", onchange: () => take([...input.files]) });
  const zone = h("div", {
    class: "drop",
    ondragover: (event) => { event.preventDefault(); zone.classList.add("over"); },
    ondragleave: () => zone.classList.remove("over"),
    ondrop: (event) => {
      event.preventDefault();
      zone.classList.remove("over");
      take([...event.dataTransfer.files]);
    },
  }, h("p", { class: "quiet" }, "Drop a film or table here, or choose one"), input);
  return zone;
}

/** A frame of a film on which the part to look at is drawn with the mouse. */
class Region {
  constructor(changed) {
    this.changed = changed;
    this.image = h("img", { alt: "a frame of the film", draggable: "false" });
    this.canvas = h("canvas");
    this.number = h("input", { type: "number", min: "0", value: "0", "aria-label": "Frame", onchange: () => this.load() });
    this.said = h("div");
    this.element = h("details", { hidden: true, ontoggle: () => this.element.open && this.load() },
      h("summary", {}, "Part of the picture to look at"),
      h("div", { class: "buttons" }, h("label", {}, "Frame", this.number),
        h("button", { onclick: () => { this.box = null; this.changed(""); this.draw(); } }, "Whole picture")),
      h("p", { class: "quiet" }, "Drag a rectangle over the picture."), this.said,
      h("div", { class: "picture" }, this.image, this.canvas));
    this.image.addEventListener("load", () => this.draw());
    let from = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      from = this.at(event);
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!from) return;
      const to = this.at(event);
      this.box = [Math.min(from[0], to[0]), Math.min(from[1], to[1]), Math.abs(to[0] - from[0]), Math.abs(to[1] - from[1])];
      this.draw();
    });
    this.canvas.addEventListener("pointerup", () => {
      from = null;
      if (this.box && this.box[2] > 3 && this.box[3] > 3) this.changed(this.box.join(","));
    });
  }

  show(film) {
    this.film = film;
    this.element.hidden = !film;
    if (film && this.element.open) this.load();
  }

  load() {
    if (this.film) this.image.src = `${address(this.film).replace(/^files/, "frames")}?number=${this.number.value || 0}`;
  }

  at(event) {
    const part = this.image.naturalWidth / this.canvas.clientWidth;
    return [event.offsetX * part, event.offsetY * part].map((value, k) =>
      Math.round(Math.max(0, Math.min(value, k ? this.image.naturalHeight : this.image.naturalWidth))));
  }

  draw() {
    Object.assign(this.canvas, { width: this.image.naturalWidth, height: this.image.naturalHeight });
    const context = this.canvas.getContext("2d");
    if (!this.box) return;
    context.fillStyle = "#0008";
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    context.clearRect(...this.box);
    context.strokeStyle = "#ff8c42";
    context.lineWidth = Math.max(2, this.canvas.width / 300);
    context.strokeRect(...this.box);
  }
}
