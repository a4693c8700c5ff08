// SPDX-License-Identifier: MIT
//
// nqm for JavaScript: `load()` gives an object with the functions of the Python package. index.d.ts has their types.
import {makeWasi} from "./wasi.js";

/** A failure, with the sentence of the command line. status: nqm_status; byte: position in the file, or -1. */
export class NqmError extends Error {
    constructor({error, status, byte}) {
        super(error);
        this.name = "NqmError";
        this.status = status;
        this.byte = byte;
    }
}

async function inflate(data) {
    const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Undo web/pack.py: `packed` is a line of JSON and a deflate stream; `place(name)` is the memory of a model file.
async function unpackModels(packed, place) {
    const newline = packed.indexOf(10);
    const index = JSON.parse(new TextDecoder().decode(packed.subarray(0, newline)));
    const stream = await inflate(packed.subarray(newline + 1));
    const models = index.map(({name}) => place(name));
    let at = 0;
    index.forEach(({n, parts}, m) => {
        const model = models[m];
        let end = 0;
        for (const {first, rows, cols, shift, same} of parts) {
            model.set(stream.subarray(at, (at += first - end)), end);
            end = first + 4 * rows * cols;
            if (same) {
                model.set(models[same[0]].subarray(same[1], same[1] + end - first), first);
                continue;
            }
            const words = new Uint32Array(model.buffer, model.byteOffset + first, rows * cols), count = rows * cols;
            for (let column = 0, i = at; column < cols; ++column)
                for (let row = 0; row < rows; ++row, ++i)
                    words[row * cols + column] = (stream[i] | (stream[i + count] << 8) | (stream[i + 2 * count] << 16)) << shift;
            at += 3 * count;
        }
        model.set(stream.subarray(at, (at += n - end)), end);
    });
}

/** Start nqm. code: WebAssembly.Module; models: bytes of nqm.models. */
export async function start(code, models) {
    const files = new Map();
    const callbacks = new Map(); // key: (n, wi, wo, rgb) => void
    let exports;
    const wasi = makeWasi(files, () => exports.memory, (line) => console.warn(line));
    const env = {
        web_call(key, n, wi, wo, rgb) {
            const doubles = (p) => new Float64Array(exports.memory.buffer, p, 3 * n);
            callbacks.get(key)(n, doubles(wi), doubles(wo), doubles(rgb));
        },
        web_progress: (done) => (nqm.onProgress ? Number(nqm.onProgress(done) === false) : 0),
    };
    const instance = await WebAssembly.instantiate(code, {wasi_snapshot_preview1: wasi, env});
    exports = instance.exports;
    exports._initialize();

    function string(s) {
        const data = new TextEncoder().encode(s), p = exports.web_alloc(data.length + 1);
        if (!p) throw new NqmError({error: "out of memory", status: -6, byte: -1});
        new Uint8Array(exports.memory.buffer).set(data, p);
        return p;
    }
    function read(p) {
        const data = new Uint8Array(exports.memory.buffer);
        return new TextDecoder().decode(data.subarray(p, data.indexOf(0, p)));
    }
    // Call a function with numbers and strings; `use` reads its result before the strings are freed.
    function call(name, args, use = read) {
        const strings = [];
        try {
            return use(exports[name](...args.map((x) => (typeof x === "string" ? strings[strings.push(string(x)) - 1] : x))));
        } finally {
            strings.forEach((p) => exports.web_free(p));
        }
    }
    function json(name, ...args) {
        const value = JSON.parse(call(name, args));
        if (value && value.error !== undefined) throw new NqmError(value);
        return value;
    }
    await unpackModels(models, (name) => call("web_model_bytes", [name], (p) => new Uint8Array(exports.memory.buffer, p)));

    const MODELS = ["default", "transport"];
    const nqm = {
        files, exports, onProgress: null,
        scoreMany: (pairs, model = "default") => json("web_score_names", MODELS.indexOf(model), JSON.stringify(pairs)),
    };
    return nqm;
}
