// Pictures and tables of a page; a click on the head of a column sorts by it.

const made = (name, words = "", kind = "") => {
  const element = document.createElement(name);
  element.textContent = words;
  if (kind) element.className = kind;
  return element;
};

/** Order of two cells [words, number or null, address]: numbers first, those without any last. */
function compared(first, second, sign) {
  if (!first[0] || !second[0]) return Boolean(second[0]) - Boolean(first[0]); // empty: at the end
  if (first[1] === null && second[1] === null) {
    return sign * first[0].localeCompare(second[0], undefined, { numeric: true });
  }
  if (first[1] === null || second[1] === null) return (first[1] === null) - (second[1] === null);
  return sign * (first[1] - second[1]);
}

function cell([words, , address], { kind }) {
  const element = made("td", address ? "" : words, kind);
  if (address) {
    const link = made("a", words);
    link.href = address;
    element.append(link);
  }
  return element;
}

/** A table with its heads; rows keep their order where they are alike. */
function sortable({ columns, rows, marked }) {
  const table = made("table"), head = made("tr"), body = made("tbody");
  const lines = rows.map((cells, k) => {
    const line = made("tr", "", marked.includes(k) ? "marked" : "");
    line.append(...cells.map((one, n) => cell(one, columns[n])));
    return { line, cells };
  });
  columns.forEach((column, n) => {
    const heading = made("th"), button = made("button", column.label);
    heading.scope = "col";
    button.type = "button";
    button.addEventListener("click", () => {
      const down = heading.getAttribute("aria-sort") === "ascending";
      for (const other of head.children) other.removeAttribute("aria-sort");
      heading.setAttribute("aria-sort", down ? "descending" : "ascending");
      lines.sort((a, b) => compared(a.cells[n], b.cells[n], down ? -1 : 1));
      body.append(...lines.map(({ line }) => line));
    });
    heading.append(button);
    head.append(heading);
  });
  const top = made("thead");
  top.append(head);
  body.append(...lines.map(({ line }) => line));
  table.append(top, body);
  return table;
}

const data = JSON.parse(document.getElementById("data").textContent);
const main = document.getElementById("main");
document.getElementById("title").textContent = data.title;
document.getElementById("outcome").textContent = data.outcome;
for (const { source, words } of data.pictures) {
  const figure = made("figure"), image = made("img");
  image.src = source;
  image.alt = words;
  figure.append(image);
  main.append(figure);
}
for (const table of data.tables) {
  const section = made("section"), frame = made("div", "", "scroll");
  frame.append(sortable(table));
  section.append(made("h2", table.title), frame, ...table.notes.map((note) => made("p", note, "note")));
  main.append(section);
}
const facts = made("section"), list = made("table");
for (const [name, words, address] of data.facts) {
  const line = made("tr");
  line.append(made("th", name), cell([words, null, address], {}));
  list.append(line);
}
facts.append(made("h2", "Origin"), list);
main.append(facts);
