// Forms from a schema: a field for each key. What is written in them is text; the server reads it.

import { h } from "./dom.js";

let fields = 0;

/** The inputs of the sections of a case; values and filling them. */
export class Form {
  /** sections: as the server has them; changed: called when a value has. */
  constructor(sections, changed) {
    this.inputs = new Map(); // "section.key" to the input
    this.kept = {}; // values that have no input, such as those of registered kinds
    this.sections = new Map(sections.map((section) => [section.name, section]));
    this.changed = changed;
  }

  /** A group of a section's fields that opens and closes. */
  group(name, { open = false, without = [] } = {}) {
    const section = this.sections.get(name);
    const keys = section.keys.filter((key) => !without.includes(key.name));
    return h("details", { open }, h("summary", {}, `[${name}] `, h("span", { class: "quiet" }, section.meaning)),
      keys.map((key) => this.field(name, key)));
  }

  field(section, key) {
    const id = `field${fields++}`;
    const input = inputOf(key, id);
    input.addEventListener("input", () => { mark(input); this.changed(); });
    this.inputs.set(`${section}.${key.name}`, input);
    const unit = key.unit && key.unit !== "rad" ? ` [${key.unit}]` : "";
    return h("div", { class: "field" }, h("label", { for: id }, `${key.name}${unit}`), input,
      h("p", { id: `${id}-words` }, key.meaning));
  }

  get(path) {
    return this.inputs.get(path)?.value ?? "";
  }

  /** Writes a value; without a word to `changed`. */
  set(path, value) {
    const input = this.inputs.get(path);
    if (!input) return;
    if (input.tagName === "SELECT" && value && ![...input.options].some((one) => one.value === value)) {
      input.append(h("option", { value }, value));
    }
    input.value = value;
    mark(input);
  }

  /** All texts, by section. */
  values() {
    const found = structuredClone(this.kept);
    for (const [path, input] of this.inputs) {
      if (input.value.trim() === "") continue;
      const [section, key] = path.split(".");
      (found[section] ??= {})[key] = input.value;
    }
    return found;
  }

  /** Writes the texts of a case; what has no input is kept as it is. */
  fill(texts) {
    for (const input of this.inputs.values()) { input.value = ""; mark(input); }
    this.kept = {};
    for (const [section, table] of Object.entries(texts)) {
      if (section === "name") continue;
      if (typeof table === "string") { this.kept[section] = table; continue; }
      for (const [key, text] of Object.entries(table)) {
        if (this.inputs.has(`${section}.${key}`)) this.set(`${section}.${key}`, text);
        else (this.kept[section] ??= {})[key] = text;
      }
    }
  }
}

function inputOf(key, id) {
  const common = { id, "aria-describedby": `${id}-words`, name: key.name };
  if (key.choices.length) {
    const usual = key.usual ? `${key.usual} (default)` : "left out";
    return h("select", common, h("option", { value: "" }, usual),
      key.choices.map((choice) => h("option", { value: choice }, choice)));
  }
  const placeholder = key.usual || (key.example ? `such as ${key.example}` : "");
  const more = { ...common, placeholder, spellcheck: "false", autocomplete: "off" };
  return key.rows > 1 ? h("textarea", { ...more, rows: key.rows }) : h("input", more);
}

/** Shows which fields are not left out. */
function mark(input) {
  input.classList.toggle("set", input.value.trim() !== "");
}
