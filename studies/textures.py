#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Pairs of textured materials with known distortions, for judging scores by labels and blame by what was changed:

    studies/textures.py make FOLDER --n 200 --seed 1     maps and FOLDER/pairs.csv, of the textures of ../shared/data/textured
    studies/textures.py label FOLDER                     their labels, which judge makes where they are missing
    studies/textures.py judge FOLDER                     their scores, and how they agree with the labels

Needs PIL (python3-pil) and NumPy. Maps are reduced to 1024 x 1024."""
import argparse
import csv
import json
import os
import pathlib
import subprocess
import sys

import numpy as np
from PIL import Image

SIDE = 1024
KINDS = ("jpeg", "blocks", "size", "squared", "decoded", "flipped", "exchanged", "scaled", "tinted", "other")


# ---- textures: {"base_color": (h, w, 3), "roughness": (h, w), "metallic": (h, w), "normal": (h, w, 3)}, bytes ----


def load(path, channel=None):
    image = Image.open(path)
    image = image.resize((SIDE, SIDE), Image.BOX) if image.width != SIDE else image
    values = np.asarray(image.convert("RGB"))
    return values if channel is None else values[..., channel]


def textures(data):
    found, chess = {}, data / "chess_set"
    for path in sorted(chess.glob("*_base_color.jpg")):
        piece, colour = path.name.split("_")[:2]
        maps = {"base_color": load(path)}
        for key, channel in (("roughness", 0), ("metallic", 0), ("normal", None)):
            names = [chess / f"{piece}_{which}_{key}.jpg" for which in (colour, "shared")]
            names = [name for name in names if name.exists()]
            if names:
                maps[key] = load(names[0], channel)
        found[f"{piece}_{colour}"] = maps
    box = data / "boombox"
    packed = load(box / "BoomBox_occlusionRoughnessMetallic.png")
    found["boombox"] = {
        "base_color": load(box / "BoomBox_baseColor.png"),
        "roughness": packed[..., 1],
        "metallic": packed[..., 2],
        "normal": load(box / "BoomBox_normal.png"),
    }
    images = data / "Images"
    found["wood"] = {"base_color": load(images / "wood_color.jpg"), "roughness": load(images / "wood_roughness.jpg", 0)}
    found["brick"] = {
        "base_color": load(images / "brick_base_gray.jpg"),
        "roughness": load(images / "brick_roughness.jpg", 0),
        "normal": load(images / "brick_normal.jpg"),
    }
    return found


# ---- distortions of one map ----


def blocks(values, side, levels, bits):
    """Each block of side x side texels has two ends along its principal axis and this many levels between, as BC1 (4, 4, 5 bits),
    BC5 (4, 8, 8), BC7 (4, 16, 8) and ASTC (8, 8, 8) nearly have."""
    v = values.reshape(SIDE, SIDE, -1).astype(float)
    n = v.shape[2]
    tiles = v.reshape(SIDE // side, side, SIDE // side, side, n).transpose(0, 2, 1, 3, 4).reshape(-1, side * side, n)
    mean = tiles.mean(1, keepdims=True)
    centred = tiles - mean
    axis = np.linalg.eigh(np.einsum("bik,bil->bkl", centred, centred))[1][:, :, -1]
    along = np.einsum("bik,bk->bi", centred, axis)
    ends = [mean[:, 0] + along.min(1)[:, None] * axis, mean[:, 0] + along.max(1)[:, None] * axis]
    step = 255 / (2**bits - 1)
    low, high = (np.round(np.clip(end, 0, 255) / step) * step for end in ends)
    length = ((high - low) ** 2).sum(1)
    place = np.einsum("bik,bk->bi", tiles - low[:, None], high - low) / np.maximum(length, 1e-9)[:, None]
    place = np.round(np.clip(place, 0, 1) * (levels - 1)) / (levels - 1)
    out = low[:, None] + place[..., None] * (high - low)[:, None]
    out = out.reshape(SIDE // side, SIDE // side, side, side, n).transpose(0, 2, 1, 3, 4).reshape(SIDE, SIDE, n)
    return np.clip(np.round(out), 0, 255).astype(np.uint8).reshape(values.shape)


def jpeg(values, quality, folder):
    path = folder / f"jpeg-{os.getpid()}.jpg"
    Image.fromarray(values).save(path, quality=quality)
    out = np.asarray(Image.open(path).convert("RGB" if values.ndim == 3 else "L"))
    path.unlink()
    return out


def reduce(values, factor):
    return np.asarray(Image.fromarray(values).resize((SIDE // factor, SIDE // factor), Image.BOX))


def decode(values):
    v = values / 255
    v = np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
    return np.round(255 * v).astype(np.uint8)


def scale(values, factor):
    return np.clip(np.round(values * factor), 0, 255).astype(np.uint8)


def distort(rng, kind, maps, others, folder):
    """The maps of the test, and the keys that were changed."""
    test, key = dict(maps), rng.choice(sorted(maps))
    keys = sorted(maps) if rng.random() < 0.4 else [key]
    if kind == "jpeg":
        quality = int(rng.choice([5, 10, 20, 40, 60, 80]))
        test.update({k: jpeg(maps[k], quality, folder) for k in keys})
    elif kind == "blocks":
        form = [(4, 4, 5), (4, 8, 8), (4, 16, 8), (8, 8, 8), (8, 4, 5)][rng.integers(5)]
        test.update({k: blocks(maps[k], *form) for k in keys})
    elif kind == "size":
        factor = int(rng.choice([2, 4, 8, 16]))
        test.update({k: reduce(maps[k], factor) for k in keys})
    elif kind == "squared":
        keys, test["roughness"] = ["roughness"], np.round((maps["roughness"] / 255.0) ** 2 * 255).astype(np.uint8)
    elif kind == "decoded":
        keys, test["roughness"] = ["roughness"], decode(maps["roughness"])
    elif kind == "flipped":
        keys, test["normal"] = ["normal"], maps["normal"] * np.uint8([1, 0, 1]) + (255 - maps["normal"]) * np.uint8([0, 1, 0])
    elif kind == "exchanged":
        keys = ["metallic", "roughness"]
        test["metallic"], test["roughness"] = maps["roughness"], maps["metallic"]
    elif kind == "scaled":
        keys, test["roughness"] = ["roughness"], scale(maps["roughness"], rng.choice([0.6, 0.8, 0.9, 1.1, 1.3]))
    elif kind == "tinted":
        keys, test["base_color"] = ["base_color"], scale(maps["base_color"], 1 - rng.choice([0.02, 0.05, 0.1, 0.2]) * rng.random(3))
    else:
        test, keys = others[rng.choice(sorted(others))], []
    return test, keys


NEEDS = {"squared": "roughness", "decoded": "roughness", "flipped": "normal", "exchanged": "metallic", "scaled": "roughness"}


def save(folder, name, maps):
    """The argument of nqm for these maps."""
    parts = []
    for key, values in sorted(maps.items()):
        path = folder / f"{name}-{key}.png"
        if not path.exists():
            Image.fromarray(values).save(path, compress_level=1)
        parts.append(f"{key}={path}")
    return "maps:" + ";".join(parts + ["model=gltf"])


def make(folder, n, seed, data):
    rng, found = np.random.default_rng(seed), textures(data)
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "pairs.csv", "w", newline="") as out:
        table = csv.writer(out)
        table.writerow(["reference", "test", "group", "kind", "changed"])
        for i in range(n):
            kind = KINDS[i % len(KINDS)]
            names = [name for name, maps in sorted(found.items()) if NEEDS.get(kind, "base_color") in maps]
            name = names[rng.integers(len(names))]
            others = {other: maps for other, maps in found.items() if other != name}
            test, keys = distort(rng, kind, found[name], others, folder)
            table.writerow([save(folder, name, found[name]), save(folder, f"{i:03d}-{kind}", test), name, kind, " ".join(keys)])


# ---- scores and labels ----


def run(*arguments):
    done = subprocess.run(["nqm", *arguments], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def label_pair(row):
    """Near: every point shows one texel, and the texture is repeated 8 times, so that all of it is seen. Far: each shows the mean of 64
    texels of anywhere."""
    pair = [row["reference"], row["test"]]
    near = run("label", *pair, "--tiles", "8", "--texels", "1", "--points", "3072", "--lights", "128", "--json")
    far = run("label", *pair, "--tiles", "1024", "--texels", "64", "--points", "512", "--lights", "128", "--json")
    return {"near": near["results"][0], "far": far["results"][0]}


def label(folder):
    """Continues where an earlier run stopped. Returns the rows with their labels."""
    path = folder / "labels.jsonl"
    done = [json.loads(line) for line in path.open()] if path.exists() else []
    rows = list(csv.DictReader(open(folder / "pairs.csv")))
    with path.open("a") as out:
        for row in rows[len(done) :]:
            done.append({"row": row, **label_pair(row)})
            out.write(json.dumps(done[-1]) + "\n")
            out.flush()
            print(f"{len(done)} of {len(rows)} labels", file=sys.stderr)
    return done


def ranks(values):
    order = np.argsort(values, kind="stable")
    placed = np.empty(len(values))
    placed[order] = np.arange(len(values))
    return placed


def spearman(a, b):
    return float(np.corrcoef(ranks(a), ranks(b))[0, 1])


def interval(function, *columns, n=2000):
    rng, size = np.random.default_rng(1), len(columns[0])
    values = [function(*(np.asarray(c)[chosen] for c in columns)) for chosen in rng.integers(0, size, (n, size))]
    return np.percentile(values, [2.5, 97.5])


def judge(folder):
    done = label(folder)
    for i, d in enumerate(done):
        d["score"] = run("score", d["row"]["reference"], d["row"]["test"], "--json")["results"][0]
        print(f"{i + 1} of {len(done)}: {d['row']['kind']} near {d['score']['jod']:.2f} label {d['near']['jod']:.2f}", file=sys.stderr)
    show(done)


def files_of(argument):
    return dict(part.split("=") for part in argument[len("maps:") :].split(";") if not part.startswith("model="))


def map_rmse(row):
    """The control: root mean square difference of all maps, as bytes; a map that one lacks differs by 128."""
    ref, test, squares = files_of(row["reference"]), files_of(row["test"]), []
    for key in sorted({*ref, *test}):
        if key in ref and key in test:
            a, b = (np.asarray(Image.open(m[key]).convert("RGB").resize((SIDE, SIDE), Image.BILINEAR), float) for m in (ref, test))
            squares.append(((a - b) ** 2).mean())
        else:
            squares.append(128.0**2)
    return float(np.sqrt(np.mean(squares)))


def mean_error(a, b):
    return float(np.abs(np.asarray(a) - np.asarray(b)).mean())


def show(done):
    near, label = [d["score"]["jod"] for d in done], [d["near"]["jod"] for d in done]
    inside = [d["score"]["jod_low"] <= d["near"]["jod"] <= d["score"]["jod_high"] for d in done]
    far, far_label = [d["score"]["texture"]["far_jod"] for d in done], [d["far"]["jod"] for d in done]
    for name, a, b in (("near", near, label), ("far", far, far_label)):
        low, high = interval(spearman, a, b)
        print(f"{name}: n {len(a)}, Spearman {spearman(a, b):.3f} [{low:.3f}, {high:.3f}], mean error {mean_error(a, b):.3f}")
    rmse = [-map_rmse(d["row"]) for d in done]
    low, high = interval(spearman, rmse, label)
    print(f"control, RMSE of the maps with near: Spearman {spearman(rmse, label):.3f} [{low:.3f}, {high:.3f}]")
    print(f"inside: {100 * np.mean(inside):.1f} %")
    for kind in KINDS:
        of = [i for i, d in enumerate(done) if d["row"]["kind"] == kind]
        if of:
            print(f"  {kind}: n {len(of)}, error {mean_error([near[i] for i in of], [label[i] for i in of]):.3f}, "
                  f"inside {100 * np.mean([inside[i] for i in of]):.0f} %")
    single = [d for d in done if d["row"]["changed"] and " " not in d["row"]["changed"] and d["score"]["texture"]["blame"]]
    named = [d["score"]["texture"]["blame"][0]["property"] == d["row"]["changed"] for d in single]
    print(f"blame: {sum(named)} of {len(single)} single changes named")
    for kind in ("squared", "decoded", "flipped", "exchanged"):
        of = [d for d in done if d["row"]["kind"] == kind]
        print(f"  {kind}: {sum(any(b['mistake'] for b in d['score']['texture']['blame']) for d in of)} of {len(of)} named")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["make", "label", "judge"])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--n", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--data", type=pathlib.Path, default=pathlib.Path(os.environ.get("NQM_DATA", "../shared/data")) / "textured")
    args = parser.parse_args()
    if args.what == "make":
        make(args.folder, args.n, args.seed, args.data)
    elif args.what == "label":
        label(args.folder)
    else:
        judge(args.folder)


if __name__ == "__main__":
    main()
