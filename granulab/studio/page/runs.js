// Runs: those that there are, one watched while it goes on, its results; two side by side.

import { address, ask, order } from "./api.js";
import { choices, h, note, put, refusal } from "./dom.js";
import { frameView } from "./frames.js";

const EVERY = 700; // ms between looks at a run that goes on

/** The room of runs; chosen: the one to show; place: gets its name, for the address. */
export function runsRoom(start, chosen, openCase, place) {
  const list = h("ul", { class: "list", "aria-label": "Runs" });
  const view = h("section", { class: "run" });
  let watching = null;
  let known = [];
  async function refresh() {
    try {
      known = await ask("runs");
    } catch (error) {
      put(list, refusal(error.message));
      return;
    }
    put(list, known.length ? known.map((run) => h("li", {}, h("button", {
      "aria-pressed": String(run.run === chosen), onclick: () => { place(run.run); show(run.run); },
    }, run.run, h("small", {}, [run.simulator, stateWords(run)].filter(Boolean).join(": ")))))
      : h("p", { class: "quiet" }, "No run in this folder yet."));
  }
  async function show(run) {
    chosen = run;
    watching?.leave();
    watching = watchedRun(run, view, { refresh, openCase, others: () => known });
    await refresh();
    view.scrollIntoView({ block: "nearest" }); // below the list on a small window
  }
  refresh().then(() => { if (chosen) show(chosen); });
  return {
    element: h("div", { class: "runs" }, h("section", {}, h("h2", {}, "Runs"), list), view),
    leave() { watching?.leave(); },
  };
}

function stateWords({ state, failure }) {
  if (state === "running" || state === "damaged") return state;
  if (state === "elsewhere") return "runs in another program";
  return failure ? `failed: ${failure}` : state;
}

/** One run in its place, looked at again and again while it goes on. */
function watchedRun(run, place, { refresh, openCase, others }) {
  const title = h("h2", {}, run);
  const bar = h("progress", { max: "100", value: "0", "aria-label": "Done" });
  const words = h("p", { class: "quiet", role: "status" });
  const stopping = h("button", { onclick: () => ordered("stop") }, "Stop");
  const resuming = h("button", { class: "main", onclick: () => ordered("resume") }, "Go on");
  const stage = h("div", { class: "watch" });
  const said = h("div"); // what an order was answered
  const state = h("div"); // what is wrong with the run now
  const results = h("div");
  put(place, title, h("div", { class: "buttons" }, stopping, resuming), bar, words, said, state, stage, results);
  let [left, timer, view, last, shown] = [false, 0, null, "", ""];

  async function ordered(what) {
    try {
      await order(what, { run });
      put(said);
    } catch (error) {
      put(said, refusal(error.message));
    }
    clearTimeout(timer);
    look();
  }
  async function look() {
    if (left) return;
    let found;
    try {
      found = await ask("run", { run });
    } catch (error) {
      put(state, refusal(error.message));
      timer = setTimeout(look, 4 * EVERY);
      return;
    }
    const going = found.state === "running" || found.state === "elsewhere";
    const { process } = found;
    stopping.hidden = found.state !== "running";
    resuming.hidden = going || found.state !== "unfinished";
    bar.hidden = ["finished", "elsewhere"].includes(found.state) || !process;
    bar.value = process?.percent ?? 0;
    put(words, doing(found));
    const wrong = going || found.state === "finished" ? "" : process?.line || found.failure;
    if (state.textContent !== wrong) put(state, refusal(wrong));
    if (found.state !== "finished") await drawFrame(found);
    if (found.state !== shown || others().every((one) => one.run !== run)) await refresh();
    if (found.state === "finished" && shown !== "finished") showResults(found);
    shown = found.state;
    if (found.state !== "finished" && !left) timer = setTimeout(look, going ? EVERY : 4 * EVERY);
  }
  async function drawFrame({ simulator, state }) {
    const frame = await ask("frame", { run }).catch(() => ({}));
    if (left || frame.time === undefined || `${frame.time}` === last) return;
    last = `${frame.time}`;
    view ??= frameView(simulator, stage);
    view.show(frame, state);
  }
  async function showResults({ simulator }) {
    stage.hidden = true;
    try {
      const found = await ask("results", { run });
      if (left) return;
      put(results, h("pre", { class: "report" }, found.words), player(run),
        compared(run, simulator, others()),
        h("div", { class: "buttons" },
          h("button", { onclick: () => openCase(simulator, found.case) }, "Open its case")),
        pictures(found.figures));
    } catch (error) {
      put(results, refusal(error.message));
    }
  }
  look();
  return { leave() { left = true; clearTimeout(timer); } };
}

function doing({ state, process }) {
  if (state === "finished") return "finished";
  if (state === "elsewhere") return "runs in another program";
  if (!process) return "unfinished; it goes on from its last checkpoint";
  const last = process.lines.at(-1) ?? "";
  if (state === "running") return `${process.percent ?? 0} % ${process.words || last}`;
  return process.state === "stopped" ? "stopped; its state is kept" : `${process.state}: ${last}`;
}

/** The page that plays the run, in a frame that may do nothing else. */
function player(run) {
  const box = h("details", { ontoggle: () => {
    if (!box.open || box.querySelector("iframe")) return;
    box.append(h("iframe", { sandbox: "allow-scripts", src: `player/${encodeURIComponent(run)}`, title: `${run}, played` }));
  } }, h("summary", {}, "Play it"));
  return box;
}

/** Pictures and films of the folder, by their names. */
export function pictures(names) {
  return h("div", { class: "figures" }, names.map((name) => {
    const words = name.split("/").at(-1);
    if (/\.(mp4|webm)$/.test(name)) return h("video", { src: address(name), controls: true, "aria-label": words });
    return h("a", { href: address(name), target: "_blank", rel: "noopener" },
      h("img", { src: address(name), alt: words, loading: "lazy" }));
  }));
}

/** Choosing another finished run of the simulator, and both side by side. */
function compared(run, simulator, runs) {
  const others = runs.filter((one) => one.run !== run && one.simulator === simulator && one.state === "finished");
  if (!others.length) return null;
  const select = choices(h("select", { "aria-label": "Another run" }), [["", others.map((one) => one.run)]], others[0].run);
  const found = h("div");
  return h("details", {}, h("summary", {}, "Compare with another run"),
    h("div", { class: "buttons" }, select, h("button", { onclick: async () => {
      note("comparing ...");
      try {
        const both = await order("compare", { first: run, second: select.value });
        put(found, h("pre", {}, both.words), pictures(both.figures));
      } catch (error) {
        put(found, refusal(error.message));
      }
    } }, "Compare")), found);
}
