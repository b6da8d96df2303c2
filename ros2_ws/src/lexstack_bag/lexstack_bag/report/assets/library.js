"use strict";
// The page's policy lets no script run without this word.
const scriptNonce = document.currentScript.nonce;

// Returns the bytes in a base64 text.
function decoded(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes.buffer;
}

// Runs a library that stands in the page as compressed text; resolves when it is there.
async function runLibrary(id) {
  const packed = new Blob([decoded(document.getElementById(id).textContent)]);
  const stream = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.nonce = scriptNonce;
  script.textContent = await new Response(stream).text();
  document.head.append(script);
}
