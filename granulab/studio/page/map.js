// Maps: the efficiency of a damper over frequency and acceleration, many runs at once.

import { ask } from "./api.js";
import { choices, h, put } from "./dom.js";
import { Task } from "./task.js";

const FIRST = ["frequencies", "gammas", "packings", "refine"];

/** The room of maps. */
export function mapRoom(start) {
  const which = h("select", { "aria-label": "Case of the map" });
  const { presets } = start.simulators.damper3d;
  const room = h("div", { class: "lab" });
  const files = () => start.files.text.filter((name) => name.endsWith(".toml"));
  ask("files").then((found) => {
    start.files = found;
    choices(which, [["Presets", presets.filter((name) => ["thesis", "damper"].includes(name))], ["In the folder", files()]], "thesis");
  });
  ask("task", { task: "damper3d map" }).then((form) => {
    const own = () => files().includes(which.value);
    const task = new Task("damper3d map", form, () => (own() ? [which.value] : []), () => (own() ? [] : [which.value]));
    const first = task.fields((name) => FIRST.includes(name));
    const others = task.fields((name) => !FIRST.includes(name));
    task.inputs.get("frequencies").value = "20,40,80";
    task.inputs.get("gammas").value = "2,5,10,20";
    task.answer = (found) => {
      const best = summaryOf(found.said);
      return h("p", { class: "fine" }, best);
    };
    put(room, h("section", {}, h("p", { class: "quiet" }, form.meaning),
      h("div", { class: "field" }, h("label", {}, "Case", which)), first,
      h("div", { class: "buttons" }, h("button", { class: "main", onclick: () => task.start() }, "Map")),
      h("details", {}, h("summary", {}, "Changes of the case"), others)), task.output());
  });
  return { element: room, leave() {} };
}

/** A line on what a map found, from its JSON. */
function summaryOf(said) {
  try {
    const found = JSON.parse(said);
    return `${found.done} of ${found.runs} runs; table in ${found.folder}/table.csv`;
  } catch {
    return said;
  }
}
