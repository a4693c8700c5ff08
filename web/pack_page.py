#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Packs the page: pack_page.py NQM_WASM MODELS PAGE.

The page is UTF-16 with a byte order mark, so that two bytes of data are one character and no server can declare another encoding: base64
would take a third more. Characters that HTML changes or UTF-16 does not allow follow the character 1, with the highest bit inverted.
Scripts are allowed by their hashes; the policy forbids every connection.
"""
import array
import base64
import hashlib
import pathlib
import re
import struct
import sys
import zlib

HERE = pathlib.Path(__file__).parent


def encode(data):
    words = array.array("H", data + b"\0" * (len(data) % 2))
    if sys.byteorder == "big":
        words.byteswap()
    out = array.array("H")
    for word in words:
        if word in (0, 1, 13, 60) or 0xD800 <= word < 0xE000:
            out.append(1)
            word ^= 0x8000
        out.append(word)
    return out.tobytes().decode("utf-16-le" if sys.byteorder == "little" else "utf-16-be")


def script(*names):
    """Modules one after the other, without imports and exports."""
    text = "\n".join((HERE / name).read_text() for name in names)
    return re.sub(r"^export ", "", re.sub(r"^import .*\n", "", text, flags=re.M), flags=re.M)


def source_hash(text):
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"


def main(code_path, models_path, page_path):
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    code = deflate.compress(pathlib.Path(code_path).read_bytes()) + deflate.flush()
    models = pathlib.Path(models_path).read_bytes()
    data = encode(struct.pack("<II", len(code), len(models)) + code + models)
    worker, page = script("zip.js", "wasi.js", "nqm.js", "glsl.js", "worker.js"), script("zip.js", "text.js", "charts.js", "combo.js", "files.js", "page.js")
    policy = ("default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; worker-src blob:; "
              "script-src blob: 'wasm-unsafe-eval' " + source_hash(page) + "; base-uri 'none'; form-action 'none'")
    html = (HERE / "page.html").read_text()
    parts = {"POLICY": policy, "STYLE": (HERE / "page.css").read_text() + (HERE / "charts.css").read_text(), "WORKER": worker, "SCRIPT": page, "DATA": data}
    for key, text in parts.items():
        assert key == "DATA" or "</script" not in text
        before, after = html.split("{{" + key + "}}")
        html = before + text + after if key != "DATA" else before + "{{DATA}}" + after
    before, after = html.split("{{DATA}}")
    out = b"\xff\xfe" + (before + data + after).encode("utf-16-le")
    pathlib.Path(page_path).write_bytes(out)
    print(f"{page_path}: {len(out)} bytes", file=sys.stderr)
    if len(out) > 6_000_000:
        sys.exit(f"{page_path}: {len(out)} bytes; the limit is 6000000")


if __name__ == "__main__":
    main(*sys.argv[1:])
