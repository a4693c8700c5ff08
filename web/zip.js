// SPDX-License-Identifier: MIT
//
// Deflate streams by the browser's own decoder, and zip archives.

/** The bytes of a raw deflate stream. */
export async function inflate(data) {
    const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The files of an archive, [[path, bytes]]. maxBytes: of all files together. */
export async function unzip(data, maxBytes = 1 << 29) {
    const view = new DataView(data.buffer, data.byteOffset, data.length), files = [];
    let end = data.length - 22, sum = 0;
    while (end >= 0 && view.getUint32(end, true) !== 0x06054b50) --end;
    if (end < 0) throw new Error("no end of a zip archive");
    let at = view.getUint32(end + 16, true);
    for (let i = 0; i < view.getUint16(end + 10, true); ++i) {
        if (at + 46 > data.length || view.getUint32(at, true) !== 0x02014b50) throw new Error(`byte ${at} begins no entry of a zip archive`);
        const [method, packed, size] = [view.getUint16(at + 10, true), view.getUint32(at + 20, true), view.getUint32(at + 24, true)];
        const [nName, nExtra, nComment, local] = [28, 30, 32].map((x) => view.getUint16(at + x, true)).concat(view.getUint32(at + 42, true));
        const name = new TextDecoder().decode(data.subarray(at + 46, at + 46 + nName));
        if ((sum += size) > maxBytes) throw new Error(`more than ${maxBytes} bytes`);
        if (local + 30 > data.length || (method !== 0 && method !== 8)) throw new Error(`'${name}' is stored in a way that is not read`);
        const from = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true), part = data.subarray(from, from + packed);
        if (!name.endsWith("/")) files.push([name, method ? await inflate(part) : part.slice()]);
        at += 46 + nName + nExtra + nComment;
    }
    return files;
}
