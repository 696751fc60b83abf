// Questions that a command answers: which damper, which outlet, what load; each with its inputs.

import { ask, documents, fresh, order } from "./api.js";
import { choices, confirmed, h, note, put, refusal } from "./dom.js";
import { Form } from "./form.js";
import { kept, Task } from "./task.js";

/** Questions: the command of each, its first options with what they begin with, and its file.
 *
 *  cases: simulator of the case that it takes; shipped: names in place of a file; chosen: the first
 *  one. Without cases the command has a file of its own, which a form makes.
 */
const QUESTIONS = [
  {
    words: "Which damper for my structure?", task: "damper3d design", first: { compare: "" },
  },
  {
    words: "What does a damper do to my structure?", task: "damper3d response", cases: "damper3d",
    first: { frequencies: "38,40,42", levels: "", simulate: "yes" },
    hint: "The case has a [host], your structure: open \u201chost\u201d in the room Damper, change it and save it.",
  },
  {
    words: "At which amplitude is a damper best?", task: "damper3d predict", cases: "damper3d",
    shipped: ["thesis", "damper"], first: { frequencies: "20,40,80", for: "" },
  },
  {
    words: "Efficiency over frequency and amplitude", task: "damper3d map", cases: "damper3d",
    shipped: ["thesis", "damper"],
    first: { frequencies: "20,40,80", gammas: "2,5,10,20", packings: "", refine: "" },
  },
  { words: "What load is on the wall?", task: "silo2d loads", first: {} },
  {
    words: "What load does a simulated bed put on the wall?", task: "silo2d loads CASE", cases: "silo2d",
    shipped: "presets", chosen: "A4", first: { seeds: "3", solid: "", "rough-plates": "" },
  },
  {
    words: "Which outlet is safe?", task: "silo2d clog", cases: "silo2d", shipped: "presets", chosen: "A3",
    first: { outlets: "60 mm,80 mm,100 mm", seeds: "2", avalanches: "10" },
  },
];

/** The room of questions. */
export function questionsRoom(start) {
  const which = choices(h("select", { "aria-label": "Question" }),
    [["", QUESTIONS.map(({ words }, k) => [String(k), words])]], "0");
  const left = h("section");
  const right = h("section");
  let task = null;
  async function choose() {
    const question = QUESTIONS[which.value];
    task?.leave();
    put(left);
    put(right);
    let form;
    try {
      form = await ask("task", { task: question.task });
    } catch (error) {
      put(right, refusal(error.message));
      return;
    }
    if (question !== QUESTIONS[which.value]) return; // another was chosen meanwhile
    const given = question.cases ? new Given(question, start) : new Own(question, start, form.own);
    task = new Task(question.task, form, () => given.files(), () => given.presets());
    put(left, ...inputs(question, form, task, given));
    put(right, task.output());
    task.attach();
  }
  which.addEventListener("change", choose);
  choose();
  return {
    element: h("div", { class: "lab" }, h("div", {}, h("div", { class: "buttons" }, which), left), right),
    leave() {},
  };
}

/** The form of a question; what takes long says first what it will take. */
function inputs(question, form, task, given) {
  const first = task.fields((name) => name in question.first);
  const others = question.cases ? task.fields((name) => !(name in question.first)) : [];
  for (const [name, value] of Object.entries(question.first)) task.inputs.get(name).value = value;
  const begin = h("button", { class: "main", onclick: () => task.start() }, "Start");
  const usual = task.answer;
  task.answer = (found) => [usual(found), found.dry ? h("div", { class: "buttons" }, begin) : null];
  task.asked = (one) => given.choose(one);
  task.done = () => fresh(given.start, () => given.refill());
  const button = form.dry ? h("button", { class: "main", onclick: () => task.start({}, true) }, "What will it take?") : begin;
  const box = h("div", { oninput: () => form.dry && begin.remove() }, given.element, first,
    others.length ? h("details", {}, h("summary", {}, "Other options, and changes of the case"), others) : null);
  return [h("p", { class: "quiet" }, form.meaning), h("div", { class: "buttons" }, button), box];
}

/** A case of the folder, or one that is shipped. */
class Given {
  constructor(question, start) {
    Object.assign(this, { question, start });
    const { shipped = [] } = question;
    this.shipped = shipped === "presets" ? start.simulators[question.cases].presets : shipped;
    this.list = kept(h("select", { "aria-label": "Case of the question" }), start, () => this.refill());
    this.refill(question.chosen ?? this.shipped[0] ?? "");
    this.element = h("div", { class: "field" }, h("label", {}, "Case", this.list), h("p", {}, question.hint ?? ""));
    fresh(start, () => this.refill());
  }

  refill(chosen = this.list.value) {
    const files = documents(this.start);
    choices(this.list, [["", this.shipped.length ? [] : [["", "a case of the folder"]]], ["Presets", this.shipped],
      ["In the folder", files]], chosen);
  }

  choose({ files, presets }) {
    this.refill(files[0] ?? presets[0] ?? "");
  }

  files() {
    return this.list.value && !this.shipped.includes(this.list.value) ? [this.list.value] : [];
  }

  presets() {
    return this.shipped.includes(this.list.value) ? [this.list.value] : [];
  }
}

/** A file of the question's own kind: a form with the shipped example in it, saved under its name. */
class Own {
  constructor(question, start, { form, texts }) {
    Object.assign(this, { question, start });
    this.form = new Form(form, () => {});
    this.name = h("input", { "aria-label": "Name of the file" });
    this.list = kept(h("select", { class: "wide", "aria-label": "Open a file", onchange: () => this.open(this.list.value) }),
      start, () => this.refill());
    this.saved = new Set(); // names that this page wrote, and may write again
    this.said = h("div");
    this.element = h("div", {},
      h("div", { class: "field" }, h("label", {}, "Name", this.name), h("p", {}, "of the file that the answer is asked of")),
      h("div", { class: "buttons" }, h("label", {}, "Open"), this.list,
        h("button", { onclick: async () => { if (await this.save()) note(`saved ${this.name.value}.toml`); } }, "Save")),
      this.said, form.map((section, k) => this.form.group(section.name, { open: k < (innerWidth > 740 ? 3 : 1) })));
    this.refill();
    this.fill(texts);
  }

  refill() {
    const files = documents(this.start);
    choices(this.list, [["", [["", "a file of the folder"]]], ["In the folder", files]]);
  }

  fill(texts) {
    this.form.fill(texts);
    this.name.value = texts.name ?? this.name.value;
  }

  async open(name) {
    if (!name) return;
    put(this.said);
    try {
      this.fill(await ask("open_own", { task: this.question.task, name }));
    } catch (error) {
      put(this.said, refusal(error.message));
    }
    this.list.value = "";
  }

  choose({ files: [name] }) {
    this.saved.add(name);
    this.open(name);
  }

  /** Writes the file; asks first where another has its name. Its name, or null where it stays. */
  async save() {
    put(this.said);
    const file = `${this.name.value.trim()}.toml`;
    const body = { task: this.question.task, texts: { name: this.name.value.trim(), ...this.form.values() } };
    try {
      let done = await order("keep", { ...body, replace: this.saved.has(file) });
      if (done.exists) {
        const words = `${done.file} is there already and holds something else.`;
        if (!(await confirmed(words, "Replace it"))) return null;
        done = await order("keep", { ...body, replace: true });
      }
      this.saved.add(done.file);
      fresh(this.start, () => this.refill());
      return done.file;
    } catch (error) {
      put(this.said, refusal(error.message));
      return null;
    }
  }

  async files() {
    const file = await this.save();
    return file && [file];
  }

  presets() {
    return [];
  }
}
