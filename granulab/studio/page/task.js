// A command as a form: its options, running it, its words, answer and figures; what was started.

import { address, ask, fresh, order } from "./api.js";
import { h, put, refusal } from "./dom.js";
import { pictures } from "./runs.js";

const EVERY = 600; // ms

/** A form of a command's options; files() gives those it takes, or null where it is not to start. */
export class Task {
  constructor(task, form, files, presets = () => []) {
    Object.assign(this, { task, form, files, presets });
    this.inputs = new Map();
    this.bar = h("progress", { max: "100", value: "0", hidden: true, "aria-label": "Done" });
    this.words = h("p", { class: "quiet", role: "status" });
    this.said = h("div"); // why nothing was started
    this.ended = h("div"); // why what was started has not ended well
    this.found = h("div");
    this.earlier = h("ul", { class: "list" });
    this.before = h("details", { hidden: true }, h("summary", {}, "Started before"), this.earlier);
    this.stopping = h("button", { hidden: true, onclick: () => this.stop() }, "Stop");
    this.done = () => {};
    this.asked = () => {}; // takes what was asked for, when an earlier one is shown
    this.left = false;
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
    return h("section", {}, h("div", { class: "buttons" }, this.stopping), this.bar, this.words, this.said, this.ended, this.found,
      this.before);
  }

  options(more = {}) {
    const given = [...this.inputs].map(([name, input]) => [name, input.value]);
    return { ...Object.fromEntries(given.filter(([, value]) => value.trim())), ...more };
  }

  /** Starts the command, or with dry lets it say what it would take. */
  async start(more = {}, dry = false) {
    for (const place of [this.said, this.ended, this.found]) put(place);
    try {
      const files = await this.files();
      if (!files) return;
      const { place } = await order("measure", {
        task: this.task, files, options: this.options(more), presets: this.presets(), dry,
      });
      this.place = place;
      this.words.scrollIntoView({ block: "nearest" }); // on a telephone it stands below the form
      this.look();
    } catch (error) {
      put(this.said, refusal(error.message));
    }
  }

  async stop() {
    await order("end", { place: this.place }).catch((error) => put(this.said, refusal(error.message)));
  }

  /** Lists what this server was asked before, also by a page that was reloaded, and shows the last that fits. */
  async attach(fits = () => true) {
    await this.list();
    const last = this.known.find(fits);
    if (last && !this.place) this.show(last);
  }

  async list() {
    this.known = (await ask("started").catch(() => [])).filter((one) => one.task === this.task);
    this.before.hidden = !this.known.length;
    put(this.earlier, this.known.map((one) => h("li", {}, h("button", {
      "aria-pressed": String(one.place === this.place), onclick: () => this.show(one),
    }, one.command, h("small", {}, one.dry ? `${one.state}: what it will take` : one.state)))));
  }

  show(one) {
    this.place = one.place;
    for (const [name, input] of this.inputs) input.value = one.options[name] ?? "";
    this.asked(one);
    for (const place of [this.said, this.ended, this.found]) put(place);
    this.look();
  }

  /** Ends the looking; the command goes on. */
  leave() {
    this.left = true;
    clearTimeout(this.timer);
  }

  async look() {
    clearTimeout(this.timer);
    const { place } = this;
    let found;
    try {
      found = await ask("measured", { place });
    } catch (error) {
      if (this.left || place !== this.place) return;
      put(this.ended, refusal(error.message));
      this.timer = setTimeout(() => this.look(), 4 * EVERY);
      return;
    }
    if (this.left || place !== this.place) return;
    const going = found.state === "running";
    this.stopping.hidden = this.bar.hidden = !going;
    this.bar.value = found.percent ?? 0;
    put(this.words, going ? `${found.percent ?? 0} % ${found.words || found.lines.at(-1) || ""}` : `${found.state}: ${found.command}`);
    put(this.ended, refusal(found.line));
    if (going) {
      this.timer = setTimeout(() => this.look(), EVERY);
      return;
    }
    put(this.found, found.state === "done" ? this.answer(found) : null, pages(found.pages), pictures(found.figures));
    this.done(found);
    this.list();
  }

  answer(found) {
    return h("pre", { class: "answer" }, found.said, found.lines.join("\n"));
  }
}

/** Pages that a command made, in frames that may do nothing else, and each alone to print it. */
function pages(names) {
  return names.map((name) => {
    const src = address(name).replace(/^files/, "answer");
    const title = name.split("/").at(-1);
    return h("div", {}, h("iframe", { sandbox: "allow-scripts", src, title }),
      h("p", { class: "quiet" }, h("a", { href: src, target: "_blank", rel: "noopener" }, `${title} alone`), ` (${name})`));
  });
}

/** A list that is refilled, when it gets focus, where the folder's files are no longer those it has. */
export function kept(list, start, refill) {
  let seen = JSON.stringify(start.files);
  list.addEventListener("focus", () => fresh(start, () => {
    const now = JSON.stringify(start.files);
    if (now === seen) return;
    seen = now;
    refill();
  }));
  return list;
}
