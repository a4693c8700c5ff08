// SPDX-License-Identifier: MIT
//
// The module for node and for bundlers: load() reads nqm.wasm and nqm.models next to this file.
import {NqmError, rawPicture, start} from "./nqm.js";

async function read(name) {
    const url = new URL(name, import.meta.url);
    if (url.protocol !== "file:") return new Uint8Array(await (await fetch(url)).arrayBuffer());
    const {readFile} = await import("node:fs/promises");
    return new Uint8Array(await readFile(url));
}

/** Start nqm. */
export async function load() {
    const code = read("nqm.wasm").then((bytes) => WebAssembly.compile(bytes));
    return start(code, await read("nqm.models"));
}
export {NqmError, rawPicture};
