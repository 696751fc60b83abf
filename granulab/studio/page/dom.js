// Elements of the page. What comes from files and people is set as text, never as markup.

/** An element with attributes (functions: listeners of what follows "on") and children. */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

/** The children of an element, replaced. */
export function put(element, ...children) {
  element.replaceChildren(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

let fading = 0;

/** A line at the foot of the page, for some seconds. */
export function note(words) {
  const place = document.getElementById("note");
  place.textContent = words;
  place.hidden = false;
  clearTimeout(fading);
  fading = setTimeout(() => { place.hidden = true; }, 6000);
}

/** A refusal in its box; nothing for an empty one. */
export function refusal(line) {
  return line ? h("p", { class: "refused", role: "alert" }, line) : null;
}

/** Asks for a yes; resolves to whether it came. */
export function confirmed(words, yes) {
  return new Promise((resolve) => {
    const dialog = h("dialog", { onclose: () => { dialog.remove(); resolve(dialog.returnValue === "yes"); } },
      h("p", {}, words),
      h("div", { class: "buttons" },
        h("button", { class: "main", onclick: () => dialog.close("yes") }, yes),
        h("button", { onclick: () => dialog.close("no") }, "Cancel")));
    document.body.append(dialog);
    dialog.showModal();
  });
}

/** A dialog with a heading and a way to close it; loss(): what is lost then, to be asked first. */
export function opened(heading, loss, ...children) {
  const leave = async (event) => {
    event.preventDefault();
    const lost = loss();
    if (!lost || (await confirmed(lost, "Close"))) dialog.close();
  };
  const dialog = h("dialog", {
    "aria-label": heading, onclose: () => dialog.remove(), oncancel: leave,
    onkeydown: (event) => event.key === "Escape" && leave(event), // browsers cancel a second time without asking
  }, h("div", { class: "buttons" }, h("h2", {}, heading),
    h("button", { onclick: leave, "aria-label": "Close" }, "Close")),
    ...children);
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}

/** Options of a select in groups: [[label, [value, ...]], ...]; a value may be [value, words]. */
export function choices(select, groups, chosen = "") {
  put(select, groups.filter(([, values]) => values.length).map(([label, values]) => {
    const options = values.map((value) => {
      const [own, words] = Array.isArray(value) ? value : [value, value];
      return h("option", { value: own, selected: own === chosen }, words);
    });
    return label ? h("optgroup", { label }, options) : options;
  }).flat());
  select.value = chosen;
  return select;
}

/** Gives a view's canvas the pixels of its place, and the view its width, height, pixels a px. */
export function filled(view) {
  const { clientWidth: width, clientHeight: height } = view.canvas.parentElement;
  if (!width || !height) return false;
  const ratio = devicePixelRatio || 1;
  Object.assign(view, { width, height, ratio });
  view.canvas.width = Math.round(width * ratio);
  view.canvas.height = Math.round(height * ratio);
  return true;
}
