// SPDX-License-Identifier: MIT
//
// nqm for JavaScript: `load()` gives an object with the functions of the Python package. index.d.ts has their types.
import {makeWasi} from "./wasi.js";
import {inflate} from "./zip.js";

/** A failure, with the sentence of the command line. status: nqm_status; byte: position in the file, or -1. */
export class NqmError extends Error {
    constructor({error, status, byte}) {
        super(error);
        this.name = "NqmError";
        this.status = status;
        this.byte = byte;
    }
}

/** A decoded picture as a file of nqm: pixels RGBA (height, width, 4). Grey pictures become one channel, opaque ones three. */
export function rawPicture(width, height, pixels) {
    let isGrey = true, isOpaque = true;
    for (let i = 0; i < pixels.length; i += 4) {
        isGrey &&= pixels[i] === pixels[i + 1] && pixels[i] === pixels[i + 2];
        isOpaque &&= pixels[i + 3] === 255;
    }
    const channels = (isGrey ? 1 : 3) + (isOpaque ? 0 : 1), file = new Uint8Array(19 + width * height * channels);
    file.set([0x89, 0x50, 0x4e, 0x47, 0x72, 0x61, 0x77]);
    [width, height, channels].forEach((x, i) => new DataView(file.buffer).setUint32(7 + 4 * i, x, true));
    for (let i = 0, at = 19; i < pixels.length; i += 4) {
        for (let k = 0; k < (isGrey ? 1 : 3); ++k) file[at++] = pixels[i + k];
        if (!isOpaque) file[at++] = pixels[i + 3];
    }
    return file;
}

// Undo web/pack_models.py: `packed` is a line of JSON and a deflate stream.
function readModels(packed) {
    const newline = packed.indexOf(10);
    return {index: JSON.parse(new TextDecoder().decode(packed.subarray(0, newline))), stream: inflate(packed.subarray(newline + 1))};
}

/** place(name): the memory of a model file. */
function unpackModels(index, stream, place) {
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

/** Start nqm. code: WebAssembly.Module or a promise of it; models: bytes of nqm.models. */
export async function start(code, models) {
    const {index, stream} = readModels(models); // is inflated while the code is compiled
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
    const instance = await WebAssembly.instantiate(await code, {wasi_snapshot_preview1: wasi, env});
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
    unpackModels(index, await stream, (name) => call("web_model_bytes", [name], (p) => new Uint8Array(exports.memory.buffer, p)));

    const MODELS = ["default", "transport"];
    const modelNumber = (name) => {
        if (!MODELS.includes(name)) throw new NqmError({error: `there is no model '${name}': here are ${MODELS.join(", ")}`, status: -5, byte: -1});
        return MODELS.indexOf(name);
    };
    const doubles = (p, n) => new Float64Array(exports.memory.buffer, p, n).slice();

    class BRDF {
        constructor(info, key) {
            Object.assign(this, info);
            this.key = key;
        }
        /** f_r (n, 3) at pairs of unit vectors wi, wo (n, 3); NaN where there is no value. */
        eval(wi, wo) {
            const n = wi.length / 3, block = n * 73 < 2 ** 31 ? exports.web_alloc(n * 73 || 1) : 0, rgb = block + 48 * n, flag = rgb + 24 * n;
            if (!block) throw new NqmError({error: "out of memory", status: -6, byte: -1});
            new Float64Array(exports.memory.buffer, block, 3 * n).set(wi);
            new Float64Array(exports.memory.buffer, block + 24 * n, 3 * n).set(wo);
            exports.web_eval(this.id, n, block, block + 24 * n, rgb, flag);
            const values = doubles(rgb, 3 * n), flags = new Uint8Array(exports.memory.buffer, flag, n);
            for (let i = 0; i < 3 * n; ++i) if (flags[Math.floor(i / 3)] === 2) values[i] = NaN;
            exports.web_free(block);
            return values;
        }
        close() {
            if (this.id >= 0) exports.web_close(this.id);
            if (this.key !== undefined) callbacks.delete(this.key);
            this.id = -1;
        }
    }

    let nextKey = 1;
    const nqm = {
        files, exports, BRDF, onProgress: null,
        ...json("web_names"),
        /** Open a path of `files` or a spec. */
        open: (name) => new BRDF(json("web_open", name)),
        /** A BRDF from a function of (n, wi, wo, rgb), arrays (n, 3), of which it fills the last. */
        fromFunction(evaluate, name = "function") {
            callbacks.set(nextKey, evaluate);
            return new BRDF(json("web_function", nextKey, name), nextKey++);
        },
        /** The materials of a file: name, surface, spec or refusal. */
        materials: (path) => json("web_materials", path),
        /** The score of a test of a reference: BRDFs, or paths and specs. */
        score(ref, test, model = "default") {
            const number = modelNumber(model);
            if (typeof ref === "string" && typeof test === "string") {
                const [score] = json("web_score_names", number, JSON.stringify([[ref, test]]));
                if (score.error !== undefined) throw new NqmError(score);
                return score;
            }
            const opened = [], use = (x) => (typeof x === "string" ? opened[opened.push(nqm.open(x)) - 1] : x);
            try {
                return json("web_score", number, use(ref).id, use(test).id);
            } finally {
                opened.forEach((brdf) => brdf.close());
            }
        },
        /** Scores of [reference, test] pairs of paths and specs; a pair that fails has `error` instead. */
        scoreMany: (pairs, model = "default") => json("web_score_names", modelNumber(model), JSON.stringify(pairs)),
        /** The near score of materials with image maps; PNG, JPEG and WebP files must be decoded (rawPicture). */
        scoreTextures(ref, test) {
            const score = json("web_score_textures", ref, test), {heat_width: width, heat_height: height, ...texture} = score.texture;
            const pixels = new Uint8ClampedArray(exports.memory.buffer, exports.web_heat(), 4 * width * height).slice();
            return {...score, texture: {...texture, heat: {width, height, pixels}}};
        },
        /** theta_h, theta_d, phi_d in degrees of the directions at which BRDFs are compared: (n, 3). */
        directions: () => doubles(exports.web_directions(), 3 * exports.web_direction_count()),
        slices: (brdf, phi = 0) => doubles(exports.web_slices(brdf.id, phi), 4 * 181 * 3),
        differenceMap: (ref, test) => doubles(exports.web_difference_map(ref.id, test.id), 60 * 90),
        costs: (ref, test) => json("web_costs", ref.id, test.id),
        /** A picture of a lit sphere, RGBA (size, size, 4). member: 0 reference, 1 test, for difference(). */
        render(brdf, member = 0, {light = "studio", size = 160, supersample = 2, turn = 0} = {}) {
            const p = call("web_render", [brdf.id, member, light, size, supersample, turn], (x) => x);
            if (!p) throw new NqmError(json("web_failure"));
            return new Uint8ClampedArray(exports.memory.buffer, p, 4 * size * size).slice();
        },
        /** Delta-E ITP between the last pictures of reference and test, of this size: {pixels, end of the colours, valid}. */
        difference(size) {
            const p = exports.web_difference();
            if (!p) throw new NqmError(json("web_failure"));
            const [end, ...valid] = doubles(exports.web_facts(), 3);
            return {pixels: new Uint8ClampedArray(exports.memory.buffer, p, 4 * size * size).slice(), end, valid};
        },
        /** Fit a shading model, write it to `path` in files, and score the file: {spec, score, dropped, selected}. */
        translate: (brdf, target, name, path) => json("web_translate", brdf.id, target, name, path),
    };
    return nqm;
}
