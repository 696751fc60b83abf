// The values of a materials file, each with its source.

import { ask } from "./api.js";
import { h, put, refusal } from "./dom.js";

/** Puts the table of a materials file into a box. */
export async function materialsTable(box, name) {
  try {
    const { values, lacking } = await ask("materials", { name });
    const sections = [...new Set(values.map((one) => one.section))];
    put(box, h("p", { class: "quiet" }, name), h("table", {}, sections.map((section) => h("tbody", {},
      h("tr", {}, h("th", { colspan: "2", scope: "rowgroup" }, section)),
      values.filter((one) => one.section === section).map((one) => h("tr", {},
        h("td", { title: one.meaning }, one.key), h("td", {}, one.value, h("span", { class: "source" },
          [one.source ?? "no source given", one.method, one.trials && `${one.trials} trials`, one.date]
            .filter(Boolean).join("; ")))))))),
    lacking.length ? h("p", { class: "quiet" }, `simulators still need: ${lacking.join(", ")}`) : null);
  } catch (error) {
    put(box, refusal(error.message));
  }
}
