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
    if (!brdf) brdf = name.startsWith("glsl:") ? nqm.fromFunction(shaders.get(name).evaluate, name) : nqm.open(inside(name));
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

// Files of a drop are in a folder of their own, whose name begins with this character and is never shown: a material finds only the maps
// that came with it. The shown paths of different drops begin with different names.
const MARK = "\u2063", HIDDEN = new RegExp(`${MARK}\\d+/`, "g");
const drops = new Map(); // first name of the shown paths: {folder, isFolder: whether paths go on}
let nDrops = 0, inDrops = null;

/** An argument with the folders of its files, and a result without them. */
const inside = (argument) => (inDrops ? argument.replace(inDrops, (name) => (drops.get(name)?.folder ?? "") + name) : argument);
const bare = (x) => (typeof x === "string" ? x.replace(HIDDEN, "") : Array.isArray(x) ? x.map(bare)
    : x?.constructor === Object ? Object.fromEntries(Object.entries(x).map(([key, value]) => [key, bare(value)])) : x);

/** Forget the drops of which no argument is in use. */
function forgetDrops(used) {
    const kept = used.map(inside).join("\n"), isGone = (folder) => !kept.includes(folder);
    forget((name) => (inside(name).match(HIDDEN) ?? []).some(isGone));
    for (const path of nqm.files.keys()) if ((path.match(HIDDEN) ?? []).some(isGone)) nqm.files.delete(path);
    for (const [name, {folder}] of drops) if (isGone(folder)) drops.delete(name);
}

/** Keep the files of a drop; returns what their shown paths begin with: nothing, or a number if another drop has one of the names. */
function addDrop(files) {
    const folder = `${MARK}${++nDrops}/`, firsts = files.map(([path]) => path.split("/"));
    let k = 1;
    if (firsts.some(([name]) => drops.has(name))) while (drops.has(String(++k)));
    const before = k > 1 ? `${k}/` : "";
    for (const [path, data] of files) nqm.files.set(folder + before + path, data);
    for (const [name, ...rest] of firsts) drops.set(before ? String(k) : name, {folder, isFolder: before !== "" || rest.length > 0});
    const names = [...drops].map(([name, {isFolder}]) => name.replace(/[.*+?^${}()|[\]\\]/g, "\\$&") + (isFolder ? "(?![^/;)])" : "(?![^:;)])"));
    inDrops = new RegExp(`(?<=^(?:ignore:[^:]*:)?|[=(])(?:${names.join("|")})`, "g");
    return before;
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

// Whether a file is a WebP picture of several frames, of which the browser would decode the first.
const isAnimation = (data) => String.fromCharCode(...data.subarray(8, 16)) === "WEBPVP8X" && (data[20] & 2) !== 0;

const MAX_DECODED = 1 << 30; // bytes of the files of all drops in use, with decoded pictures

/** Maps of materials are decoded by the browser, without colour management; a picture that it cannot decode stays as it is.
 *  used: bytes of other files. */
async function decodePicture(path, data, used) {
    const check = (width, height) => {
        if (used + 4 * width * height > MAX_DECODED) throw new RangeError(`${path}: with ${width} x ${height} pixels the files have more than ${MAX_DECODED >> 20} MiB: drop smaller ones`);
    };
    if (!/\.(png|jpe?g|webp)$/i.test(path) || isAnimation(data)) return data;
    try {
        const head = new DataView(data.buffer, data.byteOffset, data.length);
        if (data[1] === 0x50 && data.length > 24) check(head.getUint32(16), head.getUint32(20)); // of a PNG
        const bitmap = await createImageBitmap(new Blob([data]), {colorSpaceConversion: "none", premultiplyAlpha: "none"});
        check(bitmap.width, bitmap.height);
        const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
        context.drawImage(bitmap, 0, 0);
        return rawPicture(bitmap.width, bitmap.height, context.getImageData(0, 0, bitmap.width, bitmap.height).data);
    } catch (error) {
        if (error instanceof RangeError) throw error;
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
    /** used: arguments of earlier drops that are kept. */
    async addFiles(list, used) {
        forgetDrops(used);
        const files = [];
        let sum = [...nqm.files.values()].reduce((n, data) => n + data.length, 0);
        for (const [path, data] of list) {
            files.push([path, await decodePicture(path, data, sum)]);
            sum += files.at(-1)[1].length;
        }
        return addDrop(files);
    },
    open(name) {
        const {format, spec, layout, isotropic} = use(name);
        return {name, format, spec, layout, isotropic};
    },
    scoreTextures: (ref, test) => nqm.scoreTextures(inside(ref), inside(test)),
    materials: (path) => nqm.materials(inside(path)),
    score: (ref, test) => (ref + test).includes("glsl:") ? nqm.score(use(ref), use(test)) : nqm.score(inside(ref), inside(test)),
    scoreMany(pairs) {
        if (!pairs.some((pair) => pair.join().includes("glsl:"))) return nqm.scoreMany(pairs.map((pair) => pair.map(inside)));
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
        const images = [nqm.render(use(ref), 0, options), nqm.render(use(test), 1, options)], {pixels, end, valid} = nqm.difference(options.size);
        return {images: [...images, pixels], end, valid};
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
        postMessage({id, value: bare(value)});
    } catch (error) {
        postMessage({id, error: {message: bare(error.message), status: error.status ?? 0, byte: error.byte ?? -1}});
    }
};
