// @ts-check
// Adds style and program of a report, which are deflated to keep the file small. Each has its own hash in the policy.
(async () => {
  const add = async (id, element) => {
    const packed = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    element.textContent = await new Response(stream).text();
    document.head.append(element);
  };
  await add("style", document.createElement("style"));
  await add("program", Object.assign(document.createElement("script"), { type: "module" }));
})().catch((error) => { document.getElementById("app").textContent = `This page cannot start in this browser: ${error.message}`; });
