// A command as a form: its options, running it, its words, answer and figures.

import { ask, order } from "./api.js";
import { h, put, refusal } from "./dom.js";
import { pictures } from "./runs.js";

const EVERY = 600; // ms

/** A form of a command's options; files() gives those it takes. */
export class Task {
  constructor(task, form, files, presets = () => []) {
    Object.assign(this, { task, form, files, presets });
    this.inputs = new Map();
    this.bar = h("progress", { max: "100", value: "0", hidden: true, "aria-label": "Done" });
    this.words = h("p", { class: "quiet", role: "status" });
    this.said = h("div");
    this.found = h("div");
    this.stopping = h("button", { hidden: true, onclick: () => this.stop() }, "Stop");
    this.done = () => {};
  }

  /** Fields of the options, but for some. */
  fields(names) {
    return this.form.options.filter((option) => names(option.name)).map((option) => {
      const id = `task-${option.name}`;
      const input = option.choices.length
        ? h("select", { id }, h("option", { value: "" }, "left out"), option.choices.map((one) => h("option", {}, one)))
        : h(option.several ? "textarea" : "input", { id, placeholder: `such as ${option.example}`, spellcheck: "false" });
      this.inputs.set(option.name, input);
      return h("div", { class: "field" }, h("label", { for: id }, option.name), input, h("p", {}, option.meaning));
    });
  }

  output() {
    return h("section", {}, h("div", { class: "buttons" }, this.stopping), this.bar, this.words, this.said, this.found);
  }

  options(more = {}) {
    const given = [...this.inputs].map(([name, input]) => [name, input.value]);
    return { ...Object.fromEntries(given.filter(([, value]) => value.trim())), ...more };
  }

  async start(more = {}) {
    put(this.said);
    put(this.found);
    try {
      const { place } = await order("measure", {
        task: this.task, files: this.files(), options: this.options(more), presets: this.presets(),
      });
      this.place = place;
      this.look();
    } catch (error) {
      put(this.said, refusal(error.message));
    }
  }

  async stop() {
    await order("end", { place: this.place }).catch((error) => put(this.said, refusal(error.message)));
  }

  async look() {
    clearTimeout(this.timer);
    let found;
    try {
      found = await ask("measured", { place: this.place });
    } catch (error) {
      put(this.said, refusal(error.message));
      return;
    }
    const going = found.state === "running";
    this.stopping.hidden = this.bar.hidden = !going;
    this.bar.value = found.percent ?? 0;
    put(this.words, going ? `${found.percent ?? 0} % ${found.words || found.lines.at(-1) || ""}` : `${found.state}: ${found.command}`);
    if (going) {
      this.timer = setTimeout(() => this.look(), EVERY);
      return;
    }
    put(this.said, refusal(found.line));
    put(this.found, found.state === "done" ? this.answer(found) : null, pictures(found.figures));
    this.done(found);
  }

  answer(found) {
    return h("pre", { class: "answer" }, found.said, found.lines.join("\n"));
  }
}
