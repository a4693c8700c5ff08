// SPDX-License-Identifier: MIT
//
// Deflate streams by the browser's own decoder, and zip archives.

const SLICE = 1 << 16; // a decoder gives all of what it is given at once

/** The bytes of a raw deflate stream; null as soon as they are more than maxBytes. */
export async function inflate(data, maxBytes = Infinity) {
    let at = 0, sum = 0;
    const steps = new ReadableStream({pull(to) {
        to.enqueue(data.slice(at, (at += SLICE)));
        if (at >= data.length) to.close();
    }});
    const parts = [], reader = steps.pipeThrough(new DecompressionStream("deflate-raw")).getReader();
    for (;;) {
        const {done, value} = await reader.read();
        if (done) return new Uint8Array(await new Blob(parts).arrayBuffer());
        if ((sum += value.length) > maxBytes) {
            await reader.cancel();
            return null;
        }
        parts.push(value);
    }
}

/** Bytes that the files of all archives of a drop may have. */
export const MAX_UNPACKED = 1 << 29;

/** The files of an archive, [[path, bytes]]. room: {bytes} that are left of MAX_UNPACKED. What the archive says of sizes is not used. */
export async function unzip(data, room) {
    const view = new DataView(data.buffer, data.byteOffset, data.length), files = [];
    let end = data.length - 22;
    while (end >= 0 && view.getUint32(end, true) !== 0x06054b50) --end;
    if (end < 0) throw new Error("no end of a zip archive");
    let at = view.getUint32(end + 16, true);
    for (let i = 0; i < view.getUint16(end + 10, true); ++i) {
        if (at + 46 > data.length || view.getUint32(at, true) !== 0x02014b50) throw new Error(`byte ${at} begins no entry of a zip archive`);
        const [method, packed] = [view.getUint16(at + 10, true), view.getUint32(at + 20, true)];
        const [nName, nExtra, nComment, local] = [28, 30, 32].map((x) => view.getUint16(at + x, true)).concat(view.getUint32(at + 42, true));
        const name = new TextDecoder().decode(data.subarray(at + 46, at + 46 + nName));
        if (local + 30 > data.length || (method !== 0 && method !== 8)) throw new Error(`'${name}' is stored in a way that is not read`);
        const from = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true), part = data.subarray(from, from + packed);
        if (!name.endsWith("/")) {
            const bytes = method ? await inflate(part, room.bytes) : part.slice();
            if (!bytes || (room.bytes -= bytes.length) < 0) throw new Error(`with '${name}' the unpacked files have more than ${MAX_UNPACKED >> 20} MiB`);
            files.push([name, bytes]);
        }
        at += 46 + nName + nExtra + nComment;
    }
    return files;
}
