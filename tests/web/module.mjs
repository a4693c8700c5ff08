// SPDX-License-Identifier: MIT
// module.mjs MODULE NQM - the module in node: the same JODs as the command `nqm` over 500 pairs, the same sentences for bad files, and each
// function of index.d.ts.
import assert from "node:assert/strict";
import {execFileSync, spawnSync} from "node:child_process";
import {mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {pathToFileURL} from "node:url";
import {deflateSync, gzipSync} from "node:zlib";
import {listText, makePairs, readJods} from "./pairs.mjs";

const [, , folder, tool] = process.argv;
const {load, NqmError, rawPicture} = await import(pathToFileURL(join(folder, "index.js")).href);
const temporary = mkdtempSync(join(tmpdir(), "nqm-module-"));

function scores(nqm) {
    const pairs = makePairs(500), list = join(temporary, "pairs.csv");
    writeFileSync(list, listText(pairs));
    const expected = readJods(execFileSync(tool, ["batch", list], {encoding: "utf8", maxBuffer: 1 << 28}));
    const found = nqm.scoreMany(pairs);
    let worst = 0;
    found.forEach((score, i) => {
        assert.equal(score.error, undefined, pairs[i].join(" "));
        ["jod", "low", "high"].forEach((key, k) => {
            worst = Math.max(worst, Math.abs(score[key] - expected[i][k]));
        });
    });
    console.log(`largest difference from nqm batch over ${pairs.length} pairs: ${worst.toExponential(2)} JOD`);
    assert(worst < 1e-4);
    const [ref, test] = pairs[0];
    assert.deepEqual(nqm.score(ref, test), found[0]);
    assert.deepEqual(nqm.score(nqm.open(ref), nqm.open(test)), found[0]);
    assert(Math.abs(nqm.score(ref, test, "transport").jod - Number(execFileSync(tool, ["score", ref, test, "-q", "--model", "transport"]))) < 2e-4);
}

/** The table of doc/web.md: the columns of the command and of this module. */
function table(nqm) {
    const page = readFileSync(new URL("../../doc/web.md", import.meta.url), "utf8");
    const rows = [...page.matchAll(/^\| `(\S+)` \| `(\S+)` \| (\S+) \| (\S+) \|/gm)];
    assert(rows.length >= 5);
    for (const [, ref, test, byTool, here] of rows) {
        const {results: [{jod}]} = JSON.parse(execFileSync(tool, ["score", ref, test, "--json"], {encoding: "utf8"}));
        assert(Math.abs(jod - byTool) < 2e-5 && Math.abs(nqm.score(ref, test).jod - here) < 2e-5, `${ref} ${test}`);
    }
}

// The same sentence as on the command line, for files of the same name.
function sentences(nqm) {
    const files = {
        "cut.mtlx": "<materialx version=\"1.38\"><a></materialx>",
        "cut.gltf": "{\"asset\": {\"version\": \"2.0\"}, \"materials\": [",
        "empty.binary": "",
        "words.txt": "neither a material nor a BRDF",
        "glass.pbrt": "WorldBegin\nMakeNamedMaterial \"glass\" \"string type\" \"dielectric\"\n",
        "short.binary": Buffer.from([90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0, 0, 1, 2, 3]),
    };
    for (const [name, content] of Object.entries(files)) {
        writeFileSync(join(temporary, name), content);
        nqm.files.set(name, new Uint8Array(Buffer.from(content)));
    }
    for (const name of [...Object.keys(files), "missing.gltf", "wrd:nickel", "ggx:alpha=-2", "nickle"]) {
        const {stderr} = spawnSync(tool, ["score", "-q", "sgd:nickel", name], {cwd: temporary, encoding: "utf8"});
        assert.throws(() => nqm.score("sgd:nickel", name), (error) => {
            assert(error instanceof NqmError && error.status < 0);
            assert(stderr.includes(error.message), `${name}: '${error.message}' is not in '${stderr}'`);
            return true;
        }, name);
    }
}

function functions(nqm) {
    const lambert = nqm.open("lambert:kd=0.3"), mine = nqm.fromFunction((n, wi, wo, rgb) => rgb.fill(0.3 / Math.PI), "mine");
    assert.equal(nqm.score(lambert, mine).jod, 10);
    assert.equal(mine.format, "callback");
    const value = lambert.eval([0, 0, 1], [0, 0.6, 0.8]);
    assert(value.every((x) => Math.abs(x - 0.3 / Math.PI) < 1e-12));
    nqm.files.set("maps/roughness.png", rawPicture(2, 1, Uint8Array.of(60, 60, 60, 255, 200, 200, 200, 255)));
    nqm.files.set("same/roughness.png", nqm.files.get("maps/roughness.png"));
    const same = nqm.scoreTextures("maps", "same");
    assert(same.jod === 10 && same.texture.heat.width === 2 && same.texture.heat.pixels.length === 8);
    assert(nqm.scoreTextures("maps", "gltf:roughness=0.5").texture.worst < 9);
    mkdirSync(join(temporary, "exr"));
    const exr = join(temporary, "exr/base_color.exr"), plain = "gltf:base_color=0.4,0.4,0.4;roughness=0.5";
    execFileSync(tool, ["render", "lambert:kd=0.5,0.4,0.3", "--size", "16", "-o", exr]);
    nqm.files.set("exr/base_color.exr", readFileSync(exr));
    const textured = Number(execFileSync(tool, ["score", "-q", join(temporary, "exr"), plain]));
    assert(Math.abs(nqm.scoreTextures("exr", plain).jod - textured) < 1e-3);
    assert.equal(nqm.directions().length, 3 * 1872);
    assert(nqm.presets.length >= 1216 && nqm.presets.includes("sgd:nickel"));
    assert(nqm.models.find(({name}) => name === "ggx").keys.some(({name}) => name === "alpha"));
    assert(nqm.slices(lambert).filter(isFinite).every((x) => Math.abs(x - 0.3 / Math.PI) < 1e-12));
    assert(nqm.differenceMap(lambert, mine).filter(isFinite).every((x) => x < 1e-12));
    const nickel = nqm.open("sgd:nickel"), costs = nqm.costs(nickel, lambert);
    assert(costs.length === 12 && costs[0][3] >= costs[11][3] && costs[11][3] > 0);

    const size = 24, options = {light: "overcast", size, supersample: 1}, picture = nqm.render(lambert, 0, options);
    assert(picture[4 * (12 * size + 12) + 3] === 255 && picture[3] === 0); // the sphere, and the corner beside it
    assert.deepEqual(nqm.render(mine, 1, options), picture);
    assert(nqm.difference(size).end === 1);
    nqm.render(nickel, 1, options);
    assert(nqm.difference(size).end > 1);
    assert.notDeepEqual(nqm.render(nickel, 0, {...options, light: "sun", turn: 90}), nqm.render(nickel, 0, {...options, light: "sun", turn: 180}));

    let ticks = 0;
    nqm.onProgress = () => void ++ticks;
    const paint = nqm.open("open-pbr:base_color=.8,.3,.1;coat_weight=1"), {spec, score} = nqm.translate(paint, "gltf", "paint", "paint.gltf");
    assert(score.jod > 9.5 && spec.startsWith("gltf:") && ticks > 0);
    const [material] = nqm.materials("paint.gltf");
    assert(material.name === "paint" && material.refusal === null);
    writeFileSync(join(temporary, "paint.gltf"), nqm.files.get("paint.gltf"));
    const jod = Number(execFileSync(tool, ["score", "-q", "open-pbr:base_color=.8,.3,.1;coat_weight=1", join(temporary, "paint.gltf")]));
    assert(Math.abs(jod - score.jod) < 2e-4);
    nqm.onProgress = () => false;
    assert.throws(() => nqm.translate(nickel, "gltf", "a", "a.gltf"), {status: -9});
    assert.throws(() => nqm.score("sgd:nickel", "ward:nickel", "paper"), NqmError);
    mine.close();
}

/** A PNG of RGBA pixels. */
function png(side, pixels) {
    const rows = Buffer.alloc(side * (4 * side + 1));
    for (let y = 0; y < side; ++y) rows.set(pixels.subarray(4 * side * y, 4 * side * (y + 1)), y * (4 * side + 1) + 1);
    const chunk = (name, data) => {
        const body = Buffer.concat([Buffer.from(name), data]), ends = Buffer.alloc(8), gzip = gzipSync(body, {level: 0});
        ends.writeUInt32BE(data.length);
        ends.writeUInt32BE(gzip.readUInt32LE(gzip.length - 8), 4); // the CRC
        return Buffer.concat([ends.subarray(0, 4), body, ends.subarray(4)]);
    };
    const head = Buffer.from([0, 0, 0, 0, 0, 0, 0, 0, 8, 6, 0, 0, 0]);
    head.writeUInt32BE(side);
    head.writeUInt32BE(side, 4);
    return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", head), chunk("IDAT", deflateSync(rows, {level: 1})), chunk("IEND", Buffer.alloc(0))]);
}

/** Large maps with normals: products of numbers of texels exceed 32 bits. */
function large(nqm) {
    const side = 2048, wave = (x) => Math.round(127.5 + 100 * Math.sin(x));
    const maps = {
        base_color: (x, y) => [wave(x / 97), wave(y / 61), 90],
        roughness: (x, y, k) => [0, 0, 0].fill(wave((x + k * y) / 300)),
        normal: (x, y, k) => [wave(x / (40 + k)), wave(y / 55), 230],
    };
    for (const folder of ["rough", "smooth"]) {
        mkdirSync(join(temporary, folder));
        for (const [key, color] of Object.entries(maps)) {
            const pixels = new Uint8Array(4 * side * side);
            for (let i = 0; i < side * side; ++i) pixels.set([...color(i % side, i >> 11, folder === "rough" ? 1 : 2), 255], 4 * i);
            nqm.files.set(`${folder}/${key}.png`, rawPicture(side, side, pixels));
            writeFileSync(join(temporary, folder, `${key}.png`), png(side, pixels));
        }
    }
    const {results: [{jod, texture}]} = JSON.parse(execFileSync(tool, ["score", "rough", "smooth", "--json"], {cwd: temporary, encoding: "utf8"}));
    const here = nqm.scoreTextures("rough", "smooth");
    for (const [value, expected] of [[here.jod, jod], [here.texture.far, texture.far_jod], [here.texture.worst, texture.worst_jod]])
        assert(Math.abs(value - expected) < 1e-3, `${value}, nqm score ${expected}`);
}

// Every name of the types is there, and the version is that of the library.
function types(nqm) {
    assert.equal(JSON.parse(readFileSync(join(folder, "package.json"), "utf8")).version, nqm.version);
    const text = readFileSync(join(folder, "index.d.ts"), "utf8"), body = text.slice(text.indexOf("interface Nqm {"));
    for (const [, name] of body.slice(0, body.indexOf("\n}")).matchAll(/^ {4}(?:readonly )?(\w+)[(:]/gm)) assert(name in nqm, name);
}

try {
    const nqm = await load();
    types(nqm);
    scores(nqm);
    table(nqm);
    sentences(nqm);
    functions(nqm);
    large(nqm);
} finally {
    rmSync(temporary, {recursive: true});
}
