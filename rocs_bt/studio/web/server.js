// @ts-check
// Requests to the server of this page. Names from content are parameters, never parts of a path.

/** Name of the run that this page shows; empty where the server has only one. */
export const runName = new URLSearchParams(location.search).get("run") ?? "";

/** JSON of an answer. @param {Response} answer @returns {Promise<any>} */
const read = async (answer) => {
  const found = await answer.json().catch(() => ({ error: answer.statusText }));
  if (!answer.ok) throw new Error(found.error ?? answer.statusText);
  return found;
};

/** @param {string} name */
export const get = async (name) => read(await fetch(name));

/** Asks the server to do something. @param {string} name @param {object} [body] */
export const post = async (name, body = {}) => read(await fetch(`${name}${location.search}`, {
  method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body),
}));

/** Starts a run of a scenario, and goes to its page. @param {object} wanted */
export const start = async (wanted) => {
  const { run } = await post("start", wanted);
  location.assign(`run?run=${encodeURIComponent(run)}`);
};

/** Address of the editor of a file. @param {string} file */
export const edit = (file) => `edit?file=${encodeURIComponent(file)}`;

/** Copies shipped content into the project, and opens the copy. @param {string} kind @param {string} name @param {(text: string) => void} tell */
export const copy = async (kind, name, tell) => {
  try { location.assign(edit((await post("copy", { kind, name })).file)); } catch (error) { tell(error.message); }
};
