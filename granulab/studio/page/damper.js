// Dampers: enclosure, particles, motion or host, with a view of how a case begins.

import { order, send } from "./api.js";
import { Case } from "./case.js";
import { h, note, put, refusal } from "./dom.js";
import { materialsTable } from "./materials.js";
import { Space } from "./space.js";

/** The room of dampers. */
export function damperRoom(start, watch) {
  const one = new Case("damper3d", start, watch);
  const stage = h("div", { class: "stage" });
  const space = new Space(stage);
  const words = h("p", { class: "quiet", role: "status" });
  let asked = "";
  let filling = false;
  let preview = null;
  one.shown = (found) => {
    stage.classList.toggle("stale", !found.preview); // its picture is that of another case
    if (!found.preview) {
      put(words);
      return;
    }
    preview = found.preview;
    space.show({ ...preview, ...(asked === found.toml ? space.scene : {}), walls: preview.walls });
    put(words, `Fill ratio ${preview.fill_ratio.toFixed(3)}.`);
    fill(found.toml);
  };
  /** The particles as the filling lets them go; one question at a time. */
  async function fill(toml) {
    if (filling || asked === toml) return;
    filling = true;
    const slow = setTimeout(() => put(words, "Placing the particles; the first time kernels are compiled ..."), 1500);
    try {
      const texts = one.texts();
      const found = await order("fill", { simulator: "damper3d", case: texts });
      asked = toml;
      space.show({ ...preview, ...found });
      put(words, `Fill ratio ${preview.fill_ratio.toFixed(3)}. ${found.spheres
        ? "The particles as they are let go, before they settle." : "Too many particles for a look."} Drag to turn.`);
    } catch (error) {
      asked = toml;
      put(words, refusal(error.message));
    }
    clearTimeout(slow);
    filling = false;
    if (one.file.textContent && one.file.textContent !== asked) one.check(0);
  }
  const groups = ["enclosure", "particles", "motion", "host", "excitation", "fill", "run", "law", "output"];
  const room = h("div", { class: "bench" },
    h("section", { class: "keys" }, one.head(), added(one),
      groups.map((name, k) => one.form.group(name, { open: k < 3 })), sources(one)),
    h("section", { class: "drawing" }, words, stage),
    one.side());
  one.begin({ name: "damper", enclosure: { diameter: "40 mm", height: "40 mm" }, particles: { shape: "sphere:5mm" } });
  return { element: room, enter: () => one.check(0), leave() {}, take: (texts) => one.take(texts) };
}

/** Files that a case may name: cavities, meshes, signals, modes. */
function added(one) {
  const input = h("input", { type: "file", hidden: true, accept: ".stl,.obj,.csv,.wav,.toml", onchange: async () => {
    const [file] = input.files;
    input.value = "";
    try {
      note(`${await send(file)} is in the folder; name it in the case`);
      await one.lookAgain();
    } catch (error) {
      put(one.verdict, refusal(error.message));
    }
  } });
  return h("div", { class: "buttons" },
    h("button", { onclick: () => input.click() }, "Add a file (cavity, mesh, signal, modes)"), input);
}

function sources(one) {
  const box = h("div");
  const group = h("details", {
    ontoggle: () => group.open && materialsTable(box, one.form.get("particles.materials") || "acrylic"),
  }, h("summary", {}, "Materials and their sources"), box);
  one.form.inputs.get("particles.materials").addEventListener("change", () => { group.open = false; });
  return group;
}
