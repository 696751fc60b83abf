// Controls of the player: buttons, keys, pointers; and what they say.

const PACES = [1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 4, 8];
const TURN = Math.PI / 36; // of a key, in space
const STILL = 5; // px by which a pointer may move and still point

const element = (id) => document.getElementById(id);

/** Keys: what one types, how it is written, what it does in words and in fact. */
function keysOf(player) {
  const { state, view } = player;
  const toggle = (id) => element(id).click();
  const inSpace = Boolean(player.data.space);
  return [
    [[" "], "space", "play or stop", () => player.play()],
    [["ArrowLeft"], "\u2190", "a frame back, with shift ten", (e) => player.show(state.frame - (e.shiftKey ? 10 : 1))],
    [["ArrowRight"], "\u2192", "a frame on, with shift ten", (e) => player.show(state.frame + (e.shiftKey ? 10 : 1))],
    [["Home"], "home", "first frame", () => player.show(0)],
    [["End"], "end", "last frame", () => player.show(player.frames - 1)],
    [["<", ","], ",", "slower", () => pace(player, -1)],
    [[">", "."], ".", "faster", () => pace(player, 1)],
    [["+", "="], "+", "closer", () => zoom(player, 1.25)],
    [["-", "_"], "\u2212", "farther", () => zoom(player, 0.8)],
    [["0"], "0", "show all", () => fit(player)],
    ...(inSpace ? [
      [["a", "A"], "a, d", "turn to the left, right", () => turn(player, -TURN, 0)],
      [["d", "D"], "", "", () => turn(player, TURN, 0)],
      [["w", "W"], "w, x", "turn upwards, downwards", () => turn(player, 0, TURN)],
      [["x", "X"], "", "", () => turn(player, 0, -TURN)],
      [["k", "K"], "k", "next cut", () => next("cut")],
    ] : []),
    [["c", "C"], "c", "next colour", () => next("colour")],
    [["v", "V"], "v", "next curve", () => next("curve")],
    ...(player.contacts ? [[["n", "N"], "n", "contact network", () => toggle("network")]] : []),
    ...(player.arrays.wall_force ? [[["b", "B"], "b", "forces on the walls", () => toggle("walls")]] : []),
    ...(inSpace && player.data.space.moves ? [[["l", "L"], "l", "laboratory or enclosure at rest", () => toggle("lab")]] : []),
    [["p", "P"], "p", "next particle, with shift the one before", (e) => step(player, e.shiftKey ? -1 : 1)],
    [["f", "F"], "f", "follow the particle", () => state.picked >= 0 && toggle("follow")],
    [["t", "T"], "t", "its path", () => state.picked >= 0 && toggle("path")],
    [["m", "M"], "m", "measure a distance", () => view && measure(player)],
    [["s", "S"], "s", "save a picture", () => player.save()],
    [["?"], "?", "these keys", () => help()],
    [["Escape"], "esc", "let go of all that", () => letGo(player)],
  ];
}

/** Connects the page with the player. */
export function bindControls(player) {
  const { data, state, view } = player;
  element("title").textContent = data.title;
  element("outcome").textContent = data.outcome;
  element("notes").textContent = data.notes.join(" ");
  fillTable(element("facts"), data.facts);
  fillOptions(element("colour"), data.colours.map(({ label }) => label), 0);
  fillOptions(element("curve"), data.curves.map(({ name, unit }) => (unit ? `${name} [${unit}]` : name)), 0);
  fillOptions(element("pace"), PACES.map((pace) => player.paceWords(pace)), PACES.indexOf(1));
  element("scrub").max = player.frames - 1;
  element("picked").max = data.particles - 1;
  element("network-row").hidden = !player.contacts;
  element("walls-row").hidden = element("forces-of-walls").hidden = !player.arrays.wall_force;
  element("lab-row").hidden = !data.space?.moves;
  element("cut-rows").hidden = !(data.space && view);
  element("orbit-words").hidden = !data.space;
  element("lab").checked = true;
  element("path").checked = state.path;
  bindButtons(player);
  bindKeys(player);
  if (view) bindPointer(player);
  bindCurves(player);
  const shown = {};
  player.listeners.push(() => refresh(player, shown));
  player.redraw();
}

function bindButtons(player) {
  const { state, view } = player;
  const click = (id, act) => element(id).addEventListener("click", act);
  const change = (id, act, event = "change") =>
    element(id).addEventListener(event, () => act(element(id)));
  click("first", () => player.show(0));
  click("back", () => player.show(state.frame - 1));
  click("play", () => player.play());
  click("on", () => player.show(state.frame + 1));
  click("last", () => player.show(player.frames - 1));
  change("scrub", ({ value }) => {
    player.play(false);
    player.show(Number(value));
  }, "input");
  change("pace", ({ selectedIndex }) => player.set({ pace: PACES[selectedIndex] }));
  change("colour", ({ selectedIndex }) => player.set({ colour: selectedIndex }));
  change("curve", ({ selectedIndex }) => {
    player.curves.chosen = selectedIndex;
    player.redraw();
  });
  change("network", ({ checked }) => player.set({ network: checked }));
  change("walls", ({ checked }) => player.set({ wallForces: checked }));
  change("follow", ({ checked }) => player.set({ follow: checked }));
  change("path", ({ checked }) => player.set({ path: checked }));
  change("picked", ({ value }) => player.pick(value === "" ? -1 : Number(value)));
  change("lab", ({ checked }) => {
    view.inLab = checked;
    player.set({ points: [] });
  });
  const cut = () => {
    view.cut = { axis: element("cut").value, part: Number(element("cut-at").value) };
    player.redraw();
  };
  change("cut", cut);
  change("cut-at", cut, "input");
  click("measure", () => view && measure(player));
  click("picture", () => player.save());
  click("fit", () => fit(player));
  click("closer", () => zoom(player, 1.25));
  click("farther", () => zoom(player, 0.8));
  element("forces-of-walls").addEventListener("toggle", () => player.redraw());
  click("help-button", () => help());
  click("help-close", () => help());
}

function bindKeys(player) {
  const keys = keysOf(player);
  fillTable(element("keys"), keys.filter(([, name]) => name).map(([, name, words]) => [name, words]), "kbd");
  document.addEventListener("keydown", (event) => {
    const { tagName, type } = event.target;
    const typing = tagName === "SELECT" || (tagName === "INPUT" && type === "number");
    const pressing = tagName === "BUTTON" || tagName === "SUMMARY" || type === "checkbox";
    const sliding = type === "range" && event.target.id !== "scrub";
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (typing && event.key !== "Escape") return;
    if (pressing && [" ", "Enter"].includes(event.key)) return; // it acts by itself
    if (sliding && /^(Arrow|Home|End)/.test(event.key)) return;
    const found = keys.find(([names]) => names.includes(event.key));
    if (!found) return;
    event.preventDefault();
    found[3](event);
  });
}

/** Drag, wheel, two fingers, click. */
function bindPointer(player) {
  const { stage, view, state } = player;
  const pointers = new Map();
  let travelled = 0;
  const place = (event) => {
    const { left, top } = view.canvas.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  };
  stage.addEventListener("pointerdown", (event) => {
    stage.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, place(event));
    if (pointers.size === 1) travelled = 0;
  });
  stage.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = place(event), [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    travelled += Math.hypot(dx, dy);
    if (pointers.size === 2) {
      const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
      const apart = (point) => Math.hypot(point[0] - other[0], point[1] - other[1]);
      view.zoom(apart(now) / Math.max(apart(before), 1), other);
      view.drag(dx / 2, dy / 2);
    } else if (travelled > STILL) {
      if (player.data.space && !event.shiftKey && event.buttons !== 4) view.turn(-dx / 150, dy / 150);
      else view.drag(dx, dy);
    }
    if (state.follow && !player.data.space) letFollow(player);
    pointers.set(event.pointerId, now);
    player.redraw();
  });
  const up = (event) => {
    const alone = pointers.size === 1;
    if (!pointers.delete(event.pointerId) || !alone || travelled > STILL) return;
    if (event.type !== "pointerup") return;
    if (state.measuring) player.measureAt(place(event));
    else player.pick(view.pick(place(event), state.frame));
  };
  stage.addEventListener("pointerup", up);
  stage.addEventListener("pointercancel", up);
  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), place(event));
    player.redraw();
  }, { passive: false });
}

function bindCurves(player) {
  const canvas = element("curves");
  const seek = (event) => {
    const { left } = canvas.getBoundingClientRect();
    const wanted = player.curves.timeAt(event.clientX - left, player.time.at(player.state.frame));
    let low = 0, high = player.frames - 1; // the first frame that is not before it
    while (low < high) {
      const middle = (low + high) >> 1;
      if (player.time.at(middle) < wanted) low = middle + 1;
      else high = middle;
    }
    const before = Math.max(0, low - 1);
    const closer = wanted - player.time.at(before) < player.time.at(low) - wanted;
    player.play(false);
    player.show(closer ? before : low);
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    seek(event);
  });
  canvas.addEventListener("pointermove", (event) => event.buttons && seek(event));
}

// What keys and buttons do beyond a change of the state.

function pace(player, by) {
  const at = Math.max(0, Math.min(PACES.indexOf(player.state.pace) + by, PACES.length - 1));
  element("pace").selectedIndex = at;
  player.set({ pace: PACES[at] });
}

function zoom(player, factor) {
  player.view?.zoom(factor);
  player.redraw();
}

function fit(player) {
  letFollow(player);
  player.view?.fit();
  player.redraw();
}

function turn(player, round, above) {
  player.view?.turn(round, above);
  player.redraw();
}

function next(id) {
  const select = element(id);
  select.selectedIndex = (select.selectedIndex + 1) % select.options.length;
  select.dispatchEvent(new Event("change"));
}

function step(player, by) {
  const { particles } = player.data, { picked } = player.state;
  player.pick((Math.max(picked, by > 0 ? -1 : 0) + by + particles) % particles);
}

function measure(player) {
  player.set({ measuring: !player.state.measuring, points: [] });
}

function letFollow(player) {
  element("follow").checked = false;
  player.set({ follow: false });
}

function letGo(player) {
  if (!element("help").hidden) return help();
  letFollow(player);
  return player.set({ measuring: false, points: [], picked: -1 });
}

function help() {
  const dialog = element("help");
  dialog.hidden = !dialog.hidden;
  element("help-button").setAttribute("aria-expanded", String(!dialog.hidden));
  (dialog.hidden ? element("help-button") : element("help-close")).focus();
}

/** Brings words and buttons up to date; what has not changed is left alone. */
function refresh(player, shown) {
  const { state } = player;
  const write = (id, words, put = (node) => { node.textContent = words; }) => {
    if (shown[id] !== words) put(element(id));
    shown[id] = words;
  };
  write("clock", player.clockWords());
  write("scrub", state.frame, (node) => {
    node.value = state.frame;
    node.setAttribute("aria-valuetext", player.clockWords());
  });
  write("play", state.playing, (node) => {
    node.classList.toggle("playing", state.playing);
    node.setAttribute("aria-label", state.playing ? "Stop" : "Play");
  });
  write("measure", state.measuring, (node) => {
    node.setAttribute("aria-pressed", String(state.measuring));
    player.stage.classList.toggle("measuring", state.measuring);
  });
  write("measured", player.measuredWords());
  write("network-note", player.networkWords());
  write("picked", state.picked, (node) => { node.value = state.picked < 0 ? "" : state.picked; });
  const chosen = state.picked >= 0;
  for (const id of ["particle", "follow-row", "path-row"]) element(id).hidden = !chosen;
  element("pick-hint").hidden = chosen;
  if (chosen) fillTable(element("particle"), player.particleRows());
  if (player.arrays.wall_force && element("forces-of-walls").open) {
    fillTable(element("wall-table"), player.wallRows());
  }
}

function fillOptions(select, names, chosen) {
  select.replaceChildren(...names.map((name) => new Option(name)));
  select.selectedIndex = chosen;
}

/** Rows of a name and a value; cells that are there are written anew. */
function fillTable(table, rows, tag = "") {
  while (table.rows.length > rows.length) table.deleteRow(-1);
  rows.forEach(([name, value], k) => {
    const row = table.rows[k] ?? table.insertRow();
    if (!row.cells.length) {
      row.append(document.createElement("th"), document.createElement("td"));
      if (tag) row.cells[0].append(document.createElement(tag));
    }
    const head = tag ? row.cells[0].firstChild : row.cells[0];
    if (head.textContent !== name) head.textContent = name;
    if (row.cells[1].textContent !== value) row.cells[1].textContent = value;
  });
}
