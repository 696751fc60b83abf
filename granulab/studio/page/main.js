// The page: its rooms, one shown at a time.

import { ask } from "./api.js";
import { h, put, refusal } from "./dom.js";
import { damperRoom } from "./damper.js";
import { labRoom } from "./lab.js";
import { questionsRoom } from "./questions.js";
import { runsRoom } from "./runs.js";
import { siloRoom } from "./silo.js";

const room = document.getElementById("room");
const tabs = document.getElementById("tabs");

async function begin() {
  let start;
  try {
    start = await ask("start");
  } catch (error) {
    put(room, refusal(error.message));
    return;
  }
  document.getElementById("folder").textContent = start.folder;
  const kept = new Map(); // rooms that keep what was written in them
  let shown = null;
  const watch = (run) => go("runs", run);
  const openCase = (simulator, texts) => {
    go(ROOM_OF[simulator]);
    kept.get(ROOM_OF[simulator]).take(texts);
  };
  const place = (name, what) => history.pushState(null, "", address(name, what));
  const rooms = {
    silo: ["Silo", () => siloRoom(start, watch)],
    damper: ["Damper", () => damperRoom(start, watch)],
    questions: ["Questions", () => questionsRoom(start)],
    lab: ["Laboratory", () => labRoom(start)],
    runs: ["Runs", (run) => runsRoom(start, run, openCase, (chosen) => place("runs", chosen))],
  };
  function show(name, what) {
    if (shown) kept.get(shown)?.leave();
    if (name === "runs" || !kept.has(name)) kept.set(name, rooms[name][1](what));
    else kept.get(name).enter?.();
    shown = name;
    put(room, kept.get(name).element);
    for (const tab of tabs.children) {
      tab.setAttribute("aria-selected", String(tab.dataset.room === name));
      tab.tabIndex = tab.dataset.room === name ? 0 : -1;
    }
  }
  function go(name, what) {
    place(name, what);
    show(name, what);
  }
  function toAddress() {
    const [name, run] = location.hash.slice(1).split("/");
    if (name in rooms) show(name, run && decodeURIComponent(run));
    else show("silo");
  }
  put(tabs, Object.entries(rooms).map(([name, [words]]) =>
    h("button", { role: "tab", "data-room": name, onclick: () => go(name) }, words)));
  tabs.addEventListener("keydown", ({ key }) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[key];
    if (!by) return;
    const all = [...tabs.children];
    const next = all.at((all.indexOf(document.activeElement) + by) % all.length);
    next.focus();
    next.click();
  });
  addEventListener("popstate", toAddress);
  toAddress();
}

function address(name, run) {
  return run ? `#${name}/${encodeURIComponent(run)}` : `#${name}`;
}

const ROOM_OF = { silo2d: "silo", damper3d: "damper" };

begin();
