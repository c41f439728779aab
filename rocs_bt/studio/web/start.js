// @ts-check
// Starts the program of a report, which is deflated to keep the file small. Its text has its own hash in the policy.
(async () => {
  const packed = Uint8Array.from(atob(document.getElementById("program").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const script = document.createElement("script");
  script.type = "module";
  script.textContent = await new Response(stream).text();
  document.head.append(script);
})().catch((error) => { document.getElementById("app").textContent = `This page cannot start in this browser: ${error.message}`; });
