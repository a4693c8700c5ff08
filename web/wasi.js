// SPDX-License-Identifier: MIT
//
// The part of WASI (preview 1) that wasi-libc calls here, over files in memory: `files` maps paths like "gold.mtlx" or
// "brass/maps.json" to Uint8Arrays. There are no clocks but the monotonic one, no environment, and no network.

const ERRNO = {badf: 8, exist: 20, inval: 28, io: 29, isdir: 31, noent: 44};
const REGULAR = 4, DIRECTORY = 3, CHARACTER = 2;

export function makeWasi(files, memory, print) {
    const open = new Map(); // descriptor: {path, at, data, writes}
    let next = 4;
    const view = () => new DataView(memory().buffer);
    const bytes = () => new Uint8Array(memory().buffer);
    const text = (p, n) => new TextDecoder().decode(bytes().slice(p, p + n));
    const tidy = (path) => path.split("/").reduce((parts, x) => (x === ".." ? parts.slice(0, -1) : x && x !== "." ? [...parts, x] : parts), []).join("/");
    const isFolder = (path) => !path || [...files.keys()].some((name) => name.startsWith(path + "/"));
    const inode = (path) => [...path].reduce((h, c) => (h * 33n + BigInt(c.codePointAt(0))) & 0xffffffffffffn, 5381n);

    function writeStat(p, path, type) {
        const v = view();
        for (let i = 0; i < 64; i += 8) v.setBigUint64(p + i, 0n, true);
        v.setBigUint64(p + 8, inode(path), true);
        v.setUint8(p + 16, type);
        v.setBigUint64(p + 24, 1n, true);
        v.setBigUint64(p + 32, BigInt(files.get(path)?.length ?? 0), true);
        return 0;
    }

    function read(fd, iovs, n, offset, done) {
        const f = open.get(fd);
        if (!f) return ERRNO.badf;
        const data = files.get(f.path) ?? new Uint8Array();
        let at = offset ?? f.at, sum = 0;
        for (let i = 0; i < n; ++i) {
            const p = view().getUint32(iovs + 8 * i, true), size = view().getUint32(iovs + 8 * i + 4, true);
            const part = data.subarray(at, at + size);
            bytes().set(part, p);
            at += part.length;
            sum += part.length;
        }
        if (offset === undefined) f.at = at;
        view().setUint32(done, sum, true);
        return 0;
    }

    function write(fd, iovs, n, done) {
        const parts = [];
        for (let i = 0; i < n; ++i) {
            const p = view().getUint32(iovs + 8 * i, true), size = view().getUint32(iovs + 8 * i + 4, true);
            parts.push(bytes().slice(p, p + size));
        }
        const sum = parts.reduce((total, part) => total + part.length, 0);
        view().setUint32(done, sum, true);
        if (fd === 1 || fd === 2) {
            print(parts.map((part) => new TextDecoder().decode(part)).join(""));
            return 0;
        }
        const f = open.get(fd);
        if (!f) return ERRNO.badf;
        const old = files.get(f.path) ?? new Uint8Array();
        const data = new Uint8Array(Math.max(old.length, f.at + sum));
        data.set(old);
        for (const part of parts) {
            data.set(part, f.at);
            f.at += part.length;
        }
        files.set(f.path, data);
        return 0;
    }

    return {
        environ_sizes_get: (count, size) => (view().setUint32(count, 0, true), view().setUint32(size, 0, true), 0),
        environ_get: () => 0,
        clock_time_get: (id, precision, p) => (view().setBigUint64(p, BigInt(Math.round(performance.now() * 1e6)), true), 0),
        fd_prestat_get: (fd, p) => (fd === 3 ? (view().setUint32(p, 0, true), view().setUint32(p + 4, 1, true), 0) : ERRNO.badf),
        fd_prestat_dir_name: (fd, p, n) => (bytes().set(new TextEncoder().encode(".").subarray(0, n), p), 0),
        fd_fdstat_get(fd, p) {
            for (let i = 0; i < 24; i += 8) view().setBigUint64(p + i, 0n, true);
            view().setUint8(p, fd < 3 ? CHARACTER : fd === 3 ? DIRECTORY : REGULAR);
            view().setBigUint64(p + 8, ~0n & 0x1fffffffn, true);
            view().setBigUint64(p + 16, 0x1fffffffn, true);
            return fd <= 3 || open.has(fd) ? 0 : ERRNO.badf;
        },
        fd_fdstat_set_flags: () => 0,
        path_open(dir, flags, p, n, creation, rights, inheriting, fdflags, result) {
            const path = tidy(text(p, n)), [CREATE, FOLDER, NEW, EMPTY] = [1, 2, 4, 8];
            if (!files.has(path) && isFolder(path)) {
                open.set(next, {path, at: 0});
                view().setUint32(result, next++, true);
                return 0;
            }
            if (!files.has(path) && !(creation & CREATE)) return ERRNO.noent;
            if (files.has(path) && creation & NEW) return ERRNO.exist;
            if (creation & FOLDER) return ERRNO.inval;
            if (!files.has(path) || creation & EMPTY) files.set(path, new Uint8Array());
            open.set(next, {path, at: 0});
            view().setUint32(result, next++, true);
            return 0;
        },
        path_filestat_get(dir, flags, p, n, result) {
            const path = tidy(text(p, n));
            if (files.has(path)) return writeStat(result, path, REGULAR);
            return isFolder(path) ? writeStat(result, path, DIRECTORY) : ERRNO.noent;
        },
        fd_filestat_get(fd, result) {
            const f = open.get(fd);
            return f ? writeStat(result, f.path, files.has(f.path) ? REGULAR : DIRECTORY) : ERRNO.badf;
        },
        path_rename(dir, p, n, dir2, p2, n2) {
            const from = tidy(text(p, n)), to = tidy(text(p2, n2));
            if (!files.has(from)) return ERRNO.noent;
            files.set(to, files.get(from));
            files.delete(from);
            for (const f of open.values()) if (f.path === from) f.path = to;
            return 0;
        },
        path_unlink_file: (dir, p, n) => (files.delete(tidy(text(p, n))) ? 0 : ERRNO.noent),
        path_remove_directory: () => ERRNO.noent,
        path_readlink: () => ERRNO.inval,
        fd_readdir(fd, p, size, cookie, used) {
            const folder = open.get(fd)?.path ?? "", prefix = folder ? folder + "/" : "";
            const names = [...new Set([...files.keys()].filter((x) => x.startsWith(prefix)).map((x) => x.slice(prefix.length).split("/")[0]))];
            let at = 0;
            for (let i = Number(cookie); i < names.length && at < size; ++i) {
                const name = new TextEncoder().encode(names[i]), entry = new Uint8Array(24 + name.length), v = new DataView(entry.buffer);
                v.setBigUint64(0, BigInt(i + 1), true);
                v.setBigUint64(8, inode(prefix + names[i]), true);
                v.setUint32(16, name.length, true);
                v.setUint8(20, files.has(prefix + names[i]) ? REGULAR : DIRECTORY);
                entry.set(name, 24);
                bytes().set(entry.subarray(0, size - at), p + at);
                at += Math.min(entry.length, size - at);
            }
            view().setUint32(used, at, true);
            return 0;
        },
        fd_advise: () => 0,
        fd_sync: () => 0,
        fd_close: (fd) => (open.delete(fd) ? 0 : ERRNO.badf),
        fd_read: (fd, iovs, n, done) => read(fd, iovs, n, undefined, done),
        fd_pread: (fd, iovs, n, offset, done) => read(fd, iovs, n, Number(offset), done),
        fd_write: write,
        fd_seek(fd, offset, whence, result) {
            const f = open.get(fd);
            if (!f) return ERRNO.badf;
            f.at = Number(offset) + [0, f.at, files.get(f.path)?.length ?? 0][whence];
            view().setBigUint64(result, BigInt(f.at), true);
            return 0;
        },
        fd_tell: (fd, result) => (view().setBigUint64(result, BigInt(open.get(fd)?.at ?? 0), true), 0),
        proc_exit(code) {
            throw new Error("the program ended with code " + code);
        },
    };
}
