// SPDX-License-Identifier: MIT
//
// The worker of the page: nqm, called by messages {id, fn, args} and answered by {id, value} or {id, error}. web/pack_page.py puts the
// modules that it imports before it.
import {makeGlsl} from "./glsl.js";
import {rawPicture, start} from "./nqm.js";
import {inflate} from "./zip.js";

const MAX_OPEN = 128;
const opened = new Map(); // name: BRDF, the last used at the end
const shaders = new Map(); // "glsl:NUMBER": of makeGlsl()
let nqm;

function use(name) {
    let brdf = opened.get(name);
    if (!brdf) brdf = name.startsWith("glsl:") ? nqm.fromFunction(shaders.get(name).evaluate, name) : nqm.open(name);
    opened.delete(name);
    opened.set(name, brdf);
    for (const [old, last] of opened) {
        if (opened.size <= MAX_OPEN) break;
        last.close();
        opened.delete(old);
    }
    return brdf;
}

function forget(isGone) {
    for (const [name, brdf] of opened) {
        if (!isGone(name)) continue;
        brdf.close();
        opened.delete(name);
    }
}

// Bytes of the text that web/pack_page.py wrote: 2 bytes a character; after the character 1 the highest bit is inverted.
function decode(text) {
    const words = new Uint16Array(text.length);
    let n = 0;
    for (let i = 0; i < text.length; ++i) {
        const c = text.charCodeAt(i);
        words[n++] = c === 1 ? text.charCodeAt(++i) ^ 0x8000 : c;
    }
    return new Uint8Array(words.buffer, 0, 2 * n);
}

/** Maps of materials are decoded by the browser, without colour management; a picture that it cannot decode stays as it is. */
async function decodePicture(path, data) {
    if (!/\.(png|jpe?g)$/i.test(path)) return data;
    try {
        const bitmap = await createImageBitmap(new Blob([data]), {colorSpaceConversion: "none", premultiplyAlpha: "none"});
        const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
        context.drawImage(bitmap, 0, 0);
        return rawPicture(bitmap.width, bitmap.height, context.getImageData(0, 0, bitmap.width, bitmap.height).data);
    } catch {
        return data;
    }
}

const calls = {
    async start(text) {
        const data = decode(text), [nCode, nModels] = new Uint32Array(data.buffer, 0, 2), end = 8 + nCode;
        const code = inflate(data.subarray(8, end)).then((bytes) => WebAssembly.compile(bytes));
        nqm = await start(code, data.subarray(end, end + nModels));
        const {presets, models, targets, version} = nqm;
        return {presets, models, targets, version};
    },
    async addFiles(list) {
        for (const [path, data] of list) nqm.files.set(path, await decodePicture(path, data));
        forget((name) => list.some(([path]) => name.includes(path)));
    },
    open(name) {
        const {format, spec, layout, isotropic} = use(name);
        return {name, format, spec, layout, isotropic};
    },
    scoreTextures: (ref, test) => nqm.scoreTextures(ref, test),
    materials: (path) => nqm.materials(path),
    score: (ref, test) => (ref + test).includes("glsl:") ? nqm.score(use(ref), use(test)) : nqm.score(ref, test),
    scoreMany(pairs) {
        if (!pairs.some((pair) => pair.join().includes("glsl:"))) return nqm.scoreMany(pairs);
        return pairs.map(([ref, test]) => {
            try {
                return calls.score(ref, test);
            } catch (error) {
                return {error: error.message};
            }
        });
    },
    details: (ref, test) => ({
        slices: [nqm.slices(use(ref)), nqm.slices(use(test))],
        map: nqm.differenceMap(use(ref), use(test)),
        costs: nqm.costs(use(ref), use(test)),
    }),
    pictures(ref, test, options) {
        const images = [nqm.render(use(ref), 0, options), nqm.render(use(test), 1, options)], {pixels, end} = nqm.difference(options.size);
        return {images: [...images, pixels], end};
    },
    translate(ref, target, name, path, id) {
        nqm.onProgress = (done) => postMessage({id, progress: done});
        const result = nqm.translate(use(ref), target, name, path);
        return {...result, path, data: nqm.files.get(path)};
    },
    glsl(name, text) {
        const shader = makeGlsl(text);
        shaders.get(name)?.free();
        shaders.set(name, shader);
        forget((opened) => opened === name);
        return shader.parameters;
    },
    setGlsl(name, values) {
        Object.assign(shaders.get(name).values, values);
        forget((opened) => opened === name);
    },
};

onmessage = async ({data: {id, fn, args}}) => {
    try {
        const value = await calls[fn](...args, ...(fn === "translate" ? [id] : []));
        postMessage({id, value});
    } catch (error) {
        postMessage({id, error: {message: error.message, status: error.status ?? 0, byte: error.byte ?? -1}});
    }
};
