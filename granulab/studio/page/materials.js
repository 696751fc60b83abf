// The values of a materials file, each with its source.

import { ask } from "./api.js";
import { h, put, refusal } from "./dom.js";

/** Puts the table of a materials file into a box. */
export async function materialsTable(box, name) {
  try {
    const { values, lacking } = await ask("materials", { name });
    const rows = values.map((one, k) => h("tr", {},
      h("td", {}, k && values[k - 1].section === one.section ? "" : one.section),
      h("td", { title: one.meaning }, one.key), h("td", {}, one.value),
      h("td", {}, [one.source ?? "no source given", one.method, one.trials && `${one.trials} trials`, one.date]
        .filter(Boolean).join("; "))));
    put(box, h("p", { class: "quiet" }, name), h("div", { class: "scroll" }, h("table", {},
      h("thead", {}, h("tr", {}, ["of", "key", "value", "source"].map((head) => h("th", {}, head)))),
      h("tbody", {}, rows))),
    lacking.length ? h("p", { class: "quiet" }, `simulators still need: ${lacking.join(", ")}`) : null);
  } catch (error) {
    put(box, refusal(error.message));
  }
}
