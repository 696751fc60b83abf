// The page: its rooms, one shown at a time.

import { ask } from "./api.js";
import { h, put, refusal } from "./dom.js";
import { damperRoom } from "./damper.js";
import { labRoom } from "./lab.js";
import { questionsRoom } from "./questions.js";
import { runsRoom } from "./runs.js";
import { siloRoom } from "./silo.js";

const place = document.getElementById("room");
const tabs = document.getElementById("tabs");

async function begin() {
  let start;
  try {
    start = await ask("start");
  } catch (error) {
    put(place, refusal(error.message));
    return;
  }
  document.getElementById("folder").textContent = start.folder;
  const kept = new Map(); // rooms that keep what was written in them
  let shown = null;
  const watch = (run) => show("runs", run);
  const openCase = (simulator, texts) => {
    show(ROOM_OF[simulator]);
    kept.get(ROOM_OF[simulator]).fill?.(texts);
  };
  const rooms = {
    silo: ["Silo", () => siloRoom(start, watch)],
    damper: ["Damper", () => damperRoom(start, watch)],
    questions: ["Questions", () => questionsRoom(start)],
    lab: ["Laboratory", () => labRoom(start)],
    runs: ["Runs", (run) => runsRoom(start, run, openCase)],
  };
  function show(name, what) {
    if (shown) kept.get(shown)?.leave();
    if (name === "runs" || !kept.has(name)) kept.set(name, rooms[name][1](what));
    shown = name;
    put(place, kept.get(name).element);
    for (const tab of tabs.children) tab.setAttribute("aria-selected", String(tab.dataset.room === name));
    history.replaceState(null, "", `#${name}`);
  }
  put(tabs, Object.entries(rooms).map(([name, [words]]) =>
    h("button", { role: "tab", "data-room": name, onclick: () => show(name) }, words)));
  const wanted = location.hash.slice(1);
  show(wanted in rooms ? wanted : "silo");
}

const ROOM_OF = { silo2d: "silo", damper3d: "damper" };

begin();
