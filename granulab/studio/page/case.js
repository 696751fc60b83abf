// A case of a simulator: its name, its form, what the server says of it; saved, opened, run.

import { ask, documents, fresh, order } from "./api.js";
import { choices, confirmed, h, note, put, refusal } from "./dom.js";
import { Form } from "./form.js";

const PAUSE = 250; // ms without a change after which the case is checked

export class Case {
  /** simulator: name of its command; start: what the page began with; watch: shows a run. */
  constructor(simulator, start, watch) {
    Object.assign(this, { simulator, start, watch });
    this.form = new Form(start.simulators[simulator].form, () => this.check());
    this.name = h("input", { value: "case", "aria-label": "Name of the case", oninput: () => this.check() });
    this.list = h("select", { class: "wide", "aria-label": "Open a case", onfocus: () => this.lookAgain() });
    this.openButton = h("button", { onclick: () => this.open(this.list.value) }, "Open");
    this.verdict = h("div", { "aria-live": "polite" });
    this.words = h("div", { class: "scroll" });
    this.file = h("pre", { class: "toml" });
    this.digest = h("p", { class: "quiet digest" });
    this.saveButton = h("button", { onclick: () => this.save() }, "Save");
    this.figures = h("input", { type: "checkbox", checked: true });
    this.runButton = h("button", { class: "main run", onclick: () => this.run() }, "Run");
    this.shown = () => {}; // takes what the server says of the case
    this.filled = () => {}; // takes the texts of a case that was opened
    this.listed = () => {}; // called when the files of the folder were listed again
    this.place = `${start.folder}: ${simulator}`; // of the draft, in the memory of this window
    this.safe = ""; // the texts that were opened or saved last
    this.checking = this.stale = false;
    this.refreshList();
  }

  /** Name, opening and saving. */
  head() {
    return h("div", {},
      h("div", { class: "field" }, h("label", {}, "Name", this.name),
        h("p", {}, "of the case file and of the folder of its runs")),
      h("div", { class: "buttons" }, this.list, this.openButton, this.saveButton));
  }

  /** What the server says of the case, and running it. */
  side() {
    return h("section", { class: "said" },
      h("div", { class: "buttons" }, this.runButton, h("label", {}, this.figures, "with pictures and film")),
      this.verdict, this.digest,
      h("details", { open: innerWidth > 740 }, h("summary", {}, "What will be run"), this.words),
      h("details", {}, h("summary", {}, "The case file"), this.file));
  }

  refreshList() {
    const { presets } = this.start.simulators[this.simulator];
    const files = documents(this.start);
    if (String(files) === this.known) return; // an open list stays as it is
    this.known = String(files);
    choices(this.list, [["", [["", "a preset or file"]]], ["In the folder", files], ["Presets", presets]], this.list.value);
    this.listed();
  }

  /** Lists the files of the folder again: others may have come. */
  lookAgain() {
    return fresh(this.start, () => this.refreshList());
  }

  texts() {
    return { name: this.name.value.trim() || "case", ...this.form.values() };
  }

  /** Writes the texts of a case, which are kept elsewhere, into the form. */
  fill(texts) {
    this.form.fill(texts);
    if (texts.name) this.name.value = texts.name;
    this.safe = JSON.stringify(this.texts());
    this.filled(texts);
    this.check(0);
  }

  /** Begins with the draft of this window, or with a case. */
  begin(texts) {
    const draft = JSON.parse(sessionStorage.getItem(this.place) ?? "null");
    this.fill(draft?.texts ?? texts);
    if (!draft) return;
    this.safe = draft.safe;
    this.check(0); // keeps the draft as it was
  }

  /** Fills in another case, once it is known that this one may go; whether it did. */
  async take(texts) {
    const kept = JSON.stringify(this.texts()) === this.safe;
    if (!kept && !(await confirmed(`The case ${this.texts().name} is not saved.`, "Open the other"))) return false;
    this.fill(texts);
    return true;
  }

  async open(name) {
    if (!name) return;
    try {
      if (await this.take(await ask("open", { simulator: this.simulator, name }))) note(`opened ${name}`);
    } catch (error) {
      put(this.verdict, refusal(error.message));
    }
    this.list.value = "";
  }

  /** Asks the server for its verdict, once nothing has changed for a moment. */
  check(pause = PAUSE) {
    sessionStorage.setItem(this.place, JSON.stringify({ texts: this.texts(), safe: this.safe }));
    this.stale = this.runButton.disabled = this.saveButton.disabled = true;
    put(this.verdict, h("p", { class: "quiet" }, "checking ..."));
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.judge(), pause);
  }

  /** One question at a time: what is asked meanwhile is asked when the answer is there. */
  async judge() {
    if (this.checking) return;
    this.checking = true;
    while (this.stale) {
      this.stale = false;
      const asked = this.texts();
      try {
        const found = await order("check", { simulator: this.simulator, case: asked });
        if (!this.stale) this.tell(found);
      } catch (error) {
        if (!this.stale) put(this.verdict, refusal(error.message));
      }
    }
    this.checking = false;
  }

  tell(found) {
    const fine = !found.refused;
    put(this.verdict, refusal(found.refused), fine ? h("p", { class: "fine" }, inShort(found)) : null);
    put(this.file, found.toml);
    put(this.words, fine ? inRows(found.words) : "");
    put(this.digest, fine ? `Run ${found.run}, digest ${found.digest}` : "");
    this.runButton.disabled = this.saveButton.disabled = !fine;
    this.runButton.textContent = fine && found.state !== "new" ? RUN[found.state] : "Run";
    this.shown(found);
  }

  async save() {
    const done = await this.asked("save");
    if (done) note(`saved ${done.file}`);
  }

  async run() {
    this.runButton.disabled = true;
    const done = await this.asked("begin", { figures: this.figures.checked });
    this.runButton.disabled = this.stale || this.checking;
    if (done) this.watch(done.run);
  }

  /** Saves or begins; asks first where another case has the name of its file. */
  async asked(what, more = {}) {
    const body = { simulator: this.simulator, case: this.texts(), ...more };
    try {
      let done = await order(what, body);
      if (done.exists) {
        const words = `${done.file} is there already and holds another case.`;
        if (!(await confirmed(words, "Replace it"))) return null;
        done = await order(what, { ...body, replace: true });
      }
      this.safe = JSON.stringify(body.case);
      this.check(0);
      await this.lookAgain();
      return done;
    } catch (error) {
      put(this.verdict, refusal(error.message));
      return null;
    }
  }
}

/** Words in two columns. */
function inRows(rows) {
  return h("table", {}, h("tbody", {}, rows.map(([label, words]) => h("tr", {}, h("th", { scope: "row" }, label), h("td", {}, words)))));
}

const RUN = {
  finished: "Show its run", unfinished: "Go on with its run", running: "Watch its run", elsewhere: "Watch its run",
};

function inShort({ preview, state }) {
  const known = {
    new: "", unfinished: " A run of it was begun.", finished: " A run of it is finished.",
    running: " Its run goes on.", elsewhere: " Its run goes on in another program.",
  };
  return `About ${preview.expected} particles; nothing is refused.${known[state]}`;
}
