"use strict";
// Runs a library that stands in the page as compressed text; resolves when it is there.
async function runLibrary(id) {
  const letters = atob(document.getElementById(id).textContent);
  const packed = new Blob([Uint8Array.from(letters, (letter) => letter.charCodeAt(0))]);
  const stream = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text();
  document.head.append(script);
}
