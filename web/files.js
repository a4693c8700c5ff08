// SPDX-License-Identifier: MIT
//
// Files that are dropped, chosen or pasted: folders and zip archives become paths and bytes, pasted text becomes a file or a spec.
import {MAX_UNPACKED, unzip} from "./zip.js";

const COMPANION = /\.(png|jpe?g|exr|hdr|tga|ktx2|webp|csv\.meta|txt|md)$/i;

async function readEntry(entry, prefix, files) {
    if (entry.isFile) {
        const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
        files.push([prefix + file.name, file]);
        return;
    }
    const reader = entry.createReader();
    for (;;) {
        const batch = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
        if (!batch.length) return;
        for (const child of batch) await readEntry(child, `${prefix}${entry.name}/`, files);
    }
}

/** [[path, bytes]] of a DataTransfer or a list of Files. */
export async function readFiles(source) {
    const found = [];
    // Entries must be taken before the first wait.
    const entries = [...(source.items ?? [])].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
    for (const entry of entries) await readEntry(entry, "", found);
    if (!entries.length) for (const file of source.files ?? source) found.push([file.webkitRelativePath || file.name, file]);
    const files = [], room = {bytes: MAX_UNPACKED};
    for (const [path, file] of found) {
        const bytes = new Uint8Array(await file.arrayBuffer());
        if (bytes[0] === 0x50 && bytes[1] === 0x4b) {
            try {
                files.push(...(await unzip(bytes, room)).map(([name, data]) => [`${path}/${name}`, data]));
                continue;
            } catch (error) {
                throw new Error(`${path}: cannot be unpacked: ${error.message}`);
            }
        }
        files.push([path, bytes]);
    }
    return files;
}

/** The paths that may be materials: without pictures, and without the buffers of glTF files. */
export function candidates(files) {
    const hasGltf = files.some(([path]) => /\.gltf$/i.test(path));
    const rest = files.map(([path]) => path).filter((path) => !COMPANION.test(path) && !(hasGltf && /\.bin$/i.test(path)));
    return rest.length ? rest : files.map(([path]) => path);
}

/** The folders of files that are all pictures: textured materials. [] if there are other files, or pictures outside of folders. */
export function mapFolders(files) {
    const folders = new Set(files.map(([path]) => path.slice(0, Math.max(path.lastIndexOf("/"), 0))));
    return files.every(([path]) => /.\/[^/]*\.(png|jpe?g|webp)$/i.test(path)) ? [...folders] : [];
}

/** What a pasted text is: {glsl}, {file: [path, bytes]} or {spec}. */
export function readPaste(text) {
    const trimmed = text.trim();
    if (/\bvec3\s+BRDF\s*\(/.test(text)) return {glsl: text};
    const extension = /^<\?xml[\s\S]*<materialx|^<materialx/i.test(trimmed) ? "mtlx" : trimmed.startsWith("<") ? "xml"
        : trimmed.startsWith("{") ? (trimmed.includes('"asset"') ? "gltf" : "json")
        : /^\s*(Material|MakeNamedMaterial|WorldBegin|Texture)\b/m.test(trimmed) ? "pbrt" : trimmed.includes("\n") ? "txt" : "";
    return extension ? {file: [`pasted.${extension}`, new TextEncoder().encode(text)]} : {spec: trimmed};
}
