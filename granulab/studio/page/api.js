// What the page asks of its server, which is where the page came from and nowhere else.

/** An answer that is no answer: its message is the line that says why. */
export class Refused extends Error {}

// Its new token is not ours: it answers nothing, and says no more.
const RESTARTED = "the studio was restarted; open the address that its terminal shows";

/** A question; its parameters are words. */
export function ask(question, parameters = {}) {
  const query = new URLSearchParams(parameters).toString();
  return answer(fetch(`api/${question}${query ? `?${query}` : ""}`));
}

/** An order, or a question with more than an address holds. */
export function order(name, body = {}) {
  return answer(fetch(`api/${name}`, { method: "POST", body: JSON.stringify(body) }));
}

/** Sends a file into the folder; resolves to the name that it has there. */
export async function send(file) {
  const sent = fetch(`files/${encodeURIComponent(file.name)}`, { method: "PUT", body: file });
  return (await answer(sent)).name;
}

/** Calls refill with the folder's files as they are now. */
export async function fresh(start, refill) {
  start.files = await ask("files").catch(() => start.files);
  refill();
}

/** Files of the folder that are TOML: cases, shapes, materials, studies. */
export function documents(start) {
  return start.files.text.filter((name) => name.endsWith(".toml"));
}

/** Address of a file of the folder. */
export function address(name) {
  return `files/${name.split("/").map(encodeURIComponent).join("/")}`;
}

async function answer(sent) {
  let reply;
  try {
    reply = await sent;
  } catch {
    throw new Refused("the studio does not answer; is it still running?");
  }
  const found = await reply.json().catch(() => ({}));
  if (!reply.ok || found.refusal) throw new Refused(found.refusal ?? (reply.status === 404 ? RESTARTED : `answer ${reply.status}`));
  return found;
}
