// SPDX-License-Identifier: MIT
// page.mjs PAGE NQM CHROMIUM [FOLDER [TEST...]] - the page in a headless browser from file:// without network, each of its functions. FOLDER receives
// pictures of the screen; '': none. TEST: only these.
import assert from "node:assert/strict";
import {execFileSync} from "node:child_process";
import {mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {fileURLToPath, pathToFileURL} from "node:url";
import {deflateRawSync} from "node:zlib";
import {startBrowser} from "./browser.mjs";
import {listText, makePairs, readJods} from "./pairs.mjs";

const [, , page, tool, chromium, shots, ...only] = process.argv;
// A lossless picture of 4 x 2 pixels.
const WEBP = "UklGRjgAAABXRUJQVlA4TCsAAAAvA0AAAD/w+//xUNpIChy+TyKRSCSS+Y/QsNgcLo8PAgEytqBFixYR/Q9sAA==";
const url = pathToFileURL(page).href, browser = await startBrowser(chromium);
const {evaluate, until} = browser, text = (id) => evaluate(`document.getElementById("${id}").textContent`);
const jodOf = (...args) => Number(execFileSync(tool, ["score", "-q", ...args], {stdio: ["ignore", "pipe", "ignore"]}));
const hash = (ref, test) => "#" + new URLSearchParams({ref, test});

async function open(fragment = "", ...view) {
    await browser.open(url + fragment, ...view);
    await until("performance.getEntriesByName('nqm-score').length");
}

/** Wait until the page shows the JOD of this pair by the command line. */
async function expectPair(ref, test, jod = jodOf(ref, test)) {
    await until(`chosen.ref === ${JSON.stringify(ref)} && chosen.test === ${JSON.stringify(test)} && score && !document.querySelector(".result.stale")`);
    const found = await evaluate("score.jod");
    assert(Math.abs(found - jod) < 2e-4, `${ref} ${test}: ${found}, nqm score ${jod}`);
    assert.equal(await text("jod"), found.toFixed(2));
}

async function shot(name) {
    if (!shots) return;
    await until("document.body.dataset.pictures === `${chosen.ref} ${chosen.test}`", 300);
    writeFileSync(join(shots, `${name}.png`), await browser.shot());
}

/** Drop files [[path, text]] on an element, as the file manager does. */
const drop = (selector, files) => evaluate(`(() => {
    const transfer = new DataTransfer();
    for (const [name, content] of ${JSON.stringify(files)}) transfer.items.add(new File([Uint8Array.from(atob(content), (c) => c.charCodeAt(0))], name));
    document.querySelector(${JSON.stringify(selector)}).dispatchEvent(new DragEvent("drop", {bubbles: true, cancelable: true, dataTransfer: transfer}));
})()`);
const file = (name, content) => [name, Buffer.from(content).toString("base64")];
const paste = (selector, content) => evaluate(`(() => {
    const clipboardData = new DataTransfer();
    clipboardData.setData("text/plain", ${JSON.stringify(content)});
    document.querySelector(${JSON.stringify(selector)}).dispatchEvent(new ClipboardEvent("paste", {bubbles: true, cancelable: true, clipboardData}));
})()`);

/** The maps of examples/maps.py in a new folder. */
function makeMaps() {
    const folder = mkdtempSync(join(tmpdir(), "nqm-page-"));
    execFileSync("python3", [fileURLToPath(new URL("../../examples/maps.py", import.meta.url)), folder, "32"]);
    return folder;
}
/** Add files [[path, content]] as one drop; for a slot. */
const add = (files, member) => evaluate(`addFiles(${JSON.stringify(files.map(([path, content]) => [path, Buffer.from(content).toString("base64")]))}
    .map(([path, text]) => [path, Uint8Array.from(atob(text), (c) => c.charCodeAt(0))]), ${JSON.stringify(member)})`);

/** An archive of one file, whose header claims `size` bytes. */
function zip(name, content, size) {
    const packed = deflateRawSync(content), local = Buffer.alloc(30), entry = Buffer.alloc(46), end = Buffer.alloc(22);
    local.write("PK\x03\x04");
    local.writeUInt16LE(name.length, 26);
    entry.write("PK\x01\x02");
    entry.writeUInt16LE(8, 10);
    entry.writeUInt32LE(packed.length, 20);
    entry.writeUInt32LE(size, 24);
    entry.writeUInt16LE(name.length, 28);
    end.write("PK\x05\x06");
    end.writeUInt16LE(1, 10);
    end.writeUInt32LE(30 + name.length + packed.length, 16);
    return Buffer.concat([local, Buffer.from(name), packed, entry, Buffer.from(name), end]);
}

const GLTF = JSON.stringify({asset: {version: "2.0"}, materials: [0.2, 0.4, 0.6].map((roughness, i) => ({name: ["a", "b", "c"][i],
    pbrMetallicRoughness: {baseColorFactor: [0.8, 0.5, 0.2, 1], metallicFactor: 1, roughnessFactor: roughness}}))});
const gltf = (roughness) => `gltf:base_color=.8,.5,.2;metallic=1;roughness=${roughness}`;

const tests = {
    async opens() {
        await open();
        assert.equal(await text("jod"), jodOf(...(await evaluate("[EXAMPLE.ref, EXAMPLE.test]"))).toFixed(2));
        console.log("first score after", Math.round(await evaluate("performance.getEntriesByName('nqm-score')[0].startTime")), "ms");
        await shot("wide");
    },
    async link() {
        await open(hash("sgd:nickel", "ward:nickel"));
        await expectPair("sgd:nickel", "ward:nickel");
        assert.equal(await evaluate("location.hash"), hash("sgd:nickel", "ward:nickel"));
        assert.equal(await text("verdict"), "very different");
        await until("document.getElementById('costs').children.length === 8 && document.querySelectorAll('#slices svg').length === 4");
    },
    async keyboard() {
        await evaluate("document.getElementById('test-input').focus()");
        await browser.send("Input.insertText", {text: "abc brass"});
        await until("!document.getElementById('test-list').hidden");
        await browser.key("ArrowDown");
        assert.equal(await evaluate("document.querySelector('#test-list [aria-selected=true] span').textContent"), "abc:brass");
        await browser.key("Enter", "\r");
        await expectPair("sgd:nickel", "abc:brass");
        await evaluate("document.getElementById('test-input').focus(), document.getElementById('test-input').select()");
        await browser.send("Input.insertText", {text: "ggx:kd=0.1;al"});
        assert.equal(await until("document.querySelector('#test-list span')?.textContent"), "ggx:kd=0.1;alpha=");
        await evaluate("document.querySelector('.swap').click()");
        await expectPair("abc:brass", "sgd:nickel");
    },
    async fault() {
        for (const wrong of ["wrd:nickel", "ggx:alpha=-2"]) {
            await evaluate(`setPair({ref: "sgd:nickel", test: "${wrong}"})`);
            await until("!document.getElementById('fault').hidden");
            assert.throws(() => jodOf("sgd:nickel", wrong));
            const {stderr} = await import("node:child_process").then(({spawnSync}) => spawnSync(tool, ["score", "-q", "sgd:nickel", wrong], {encoding: "utf8"}));
            assert(stderr.includes(await text("fault")), `${await text("fault")} / ${stderr}`);
            assert.equal(await text("jod"), "–");
        }
    },
    async drop() {
        await drop('[data-member="ref"]', [file("three.gltf", GLTF)]);
        await until("chosen.ref === 'three.gltf:a' && document.getElementById('ref-members').options.length === 3");
        await evaluate("setPair({test: 'three.gltf:b'})");
        await expectPair("three.gltf:a", "three.gltf:b", jodOf(gltf(0.2), gltf(0.4)));
        await evaluate("(() => { const s = document.getElementById('ref-members'); s.value = 'three.gltf:c'; s.dispatchEvent(new Event('change')); })()");
        await expectPair("three.gltf:c", "three.gltf:b", jodOf(gltf(0.6), gltf(0.4)));
        await drop('[data-member="test"]', [file("cut.gltf", GLTF.slice(0, 60))]);
        await until("document.getElementById('fault').textContent.startsWith('cut.gltf: ')");
    },
    async paste() {
        await evaluate("setPair({ref: 'sgd:nickel', test: 'ward:nickel'})");
        await paste("body", GLTF);
        await until("chosen.ref === 'pasted.gltf:a' && chosen.test === 'pasted.gltf:b'");
        await paste('[data-member="test"] label', "abc:nickel");
        await expectPair("pasted.gltf:a", "abc:nickel", jodOf(gltf(0.2), "abc:nickel"));
    },
    async glsl() {
        await evaluate("setPair({ref: 'lambert:kd=0.25'})");
        const shader = "::begin parameters\nfloat albedo 0 1 0.5\n::end parameters\nvec3 BRDF(vec3 L, vec3 N, vec3 V, vec3 X, vec3 Y) { return vec3(albedo) / 3.14159265; }\n";
        await evaluate(`document.getElementById("glsl").value = ${JSON.stringify(shader)}; document.getElementById("glsl-use").click()`);
        await expectPair("lambert:kd=0.25", "glsl:shader", jodOf("lambert:kd=0.25", "lambert:kd=0.5"));
        await evaluate("(() => { const i = document.querySelector('#sliders input'); i.value = 0.25; i.dispatchEvent(new Event('input', {bubbles: true})); })()");
        await until("score?.jod > 9.999");
        await shot("glsl");
        await evaluate('document.getElementById("glsl").value = "vec3 BRDF(vec3 L, vec3 N, vec3 V, vec3 X, vec3 Y) {\\n return 1.0; }"; document.getElementById("glsl-use").click()');
        await until("!document.getElementById('glsl-fault').hidden");
        assert((await text("glsl-fault")).startsWith("line 2:"), await text("glsl-fault"));
    },
    async translate() {
        await evaluate("setPair({ref: 'open-pbr:base_color=.8,.3,.1;coat_weight=1', test: 'sgd:nickel'})");
        await evaluate("document.getElementById('target').value = 'gltf', document.getElementById('translate').click()");
        await until("document.querySelector('#translated a')", 300);
        const content = await evaluate("fetch ? new Promise((resolve) => artist.call('translate', chosen.ref, 'gltf', 'paint', 'paint.gltf').then(({data}) => resolve(new TextDecoder().decode(data)))) : 0");
        const folder = mkdtempSync(join(tmpdir(), "nqm-page-"));
        writeFileSync(join(folder, "paint.gltf"), content);
        const jod = jodOf("open-pbr:base_color=.8,.3,.1;coat_weight=1", join(folder, "paint.gltf"));
        rmSync(folder, {recursive: true});
        assert.equal(await evaluate("document.querySelector('#translated strong').textContent"), `${jod.toFixed(2)} JOD`);
    },
    async share() {
        await evaluate("document.getElementById('table-clear').click()");
        await evaluate("setPair({ref: 'sgd:nickel', test: 'perturb:gloss=.9;of=sgd:nickel'})");
        await expectPair("sgd:nickel", "perturb:gloss=.9;of=sgd:nickel");
        await evaluate("copy('command')");
        assert.equal(await text("share"), "nqm score sgd:nickel 'perturb:gloss=.9;of=sgd:nickel'");
        await evaluate("copy('markdown')");
        assert.match(await text("share"), /^\| JOD .*\n\| ---: .*\n\| \d\.\d\d \| \[.*\] \| sgd:nickel \|/);
    },
    async table() {
        await until("document.body.dataset.pictures === `${chosen.ref} ${chosen.test}`", 300);
        const specs = Array.from({length: 60}, (_, i) => `gltf:base_color=.${1 + (i % 9)},.5,.2;roughness=0.${20 + i}`);
        await evaluate("window.longest = 0, new PerformanceObserver((list) => list.getEntries().forEach(({duration}) => longest = Math.max(longest, duration))).observe({entryTypes: ['longtask']})");
        await evaluate(`addRows(${JSON.stringify(specs)})`);
        assert.equal(await evaluate("document.body.dataset.pairs"), "1770");
        console.log("60 materials:", await text("table-about"), "longest task of the page", Math.round(await evaluate("longest")), "ms");
        const jods = await evaluate("rows.map(({score}) => score.jod)");
        assert(jods.length === 1770 && jods.every((jod, i) => i === 0 || jods[i - 1] <= jod));
        const [ref, test] = await evaluate("[rows[0].ref, rows[0].test]");
        await evaluate("document.querySelector('#rows button').click()");
        await expectPair(ref, test);
        await shot("table");
    },
    async textures() {
        const folder = makeMaps();
        const read = (name, as = name) => readdirSync(join(folder, name)).map((x) => [`${as}/${x}`, readFileSync(join(folder, name, x))]);
        await add([...read("steel"), ...read("export")]);
        await expectPair("steel", "export", jodOf(join(folder, "steel"), join(folder, "export")));
        assert.match(await text("remarks"), /roughness alone: .*roughness is squared/);
        if (shots) writeFileSync(join(shots, "textures.png"), await browser.shot());
        // A textured material and a flat one, while the pictures of an earlier pair are drawn.
        const flat = "gltf:base_color=.3,.3,.3;metallic=1;roughness=.4", jod = jodOf(join(folder, "steel"), flat);
        await evaluate("setPair({ref: 'sgd:nickel', test: 'ward:nickel'})");
        await evaluate(`void setPair({ref: "steel", test: ${JSON.stringify(flat)}}), document.querySelector("[name=light]:not(:checked)").click()`);
        assert.deepEqual(await evaluate("[document.getElementById('jod').textContent, document.getElementById('verdict').textContent, document.getElementById('words').textContent]"), ["–", "Computing…", ""]);
        if (shots) writeFileSync(join(shots, "computing.png"), await browser.shot());
        await expectPair("steel", flat, jod);
        await until("!drawing");
        assert(await evaluate("document.getElementById('fault').hidden"), await text("fault"));
        if (shots) writeFileSync(join(shots, "flat.png"), await browser.shot());
        // Drops with equal names.
        await add(read("steel", "maps"), "ref");
        await add(read("export", "maps"), "test");
        await expectPair("maps", "2/maps", jodOf(join(folder, "steel"), join(folder, "export")));
        await add(read("steel", "maps"), "test");
        await until("chosen.test === '3/maps'");
        await expectPair("maps", "3/maps", 10);
        await add([["maps.csv", "theta_h,theta_d,phi_d,r,g,b\n"]], "ref");
        assert.match(await text("fault"), /^maps.csv: /);
        // A material whose map was not dropped does not read that of another drop.
        const material = (map) => JSON.stringify({asset: {version: "2.0"}, images: [{uri: map}], textures: [{source: 0}], materials: [{pbrMetallicRoughness: {baseColorTexture: {index: 0}}}]});
        const [color] = read("steel").filter(([path]) => /color/i.test(path));
        await add([["a.gltf", material("color.png")]], "ref");
        await add([["b.gltf", material("color.png")], ["color.png", color[1]]], "test");
        await until("chosen.test === 'b.gltf' && document.getElementById('verdict').textContent === 'No score'");
        assert.match(await text("fault"), /'color.png' of the material a.gltf/);
        const webp = Buffer.from(WEBP, "base64"), animated = Buffer.from(webp);
        writeFileSync(join(folder, "base_color.webp"), webp);
        animated.write("VP8X", 12, "latin1");
        animated[20] = 2;
        await add([["w/base_color.webp", webp]], "ref");
        await evaluate("setPair({test: 'gltf:roughness=.5'})");
        await expectPair("w", "gltf:roughness=.5", jodOf(`maps:base_color=${join(folder, "base_color.webp")}`, "gltf:roughness=.5"));
        await add([["v/base_color.webp", animated]], "ref");
        await until("chosen.ref === 'v' && document.getElementById('verdict').textContent === 'No score'");
        assert.match(await text("fault"), /base_color.webp.*: an animated WebP picture, or one that/);
        rmSync(folder, {recursive: true});
        await evaluate("setPair({ref: 'sgd:nickel', test: 'ward:nickel'})");
    },
    async holes() {
        const folder = mkdtempSync(join(tmpdir(), "nqm-page-")), csv = join(folder, "part.csv"), rows = ["theta_i,phi_i,theta_o,phi_o,r,g,b"];
        const angles = [0, 10, 20, 30, 40, 50, 60, 70, 80, 86]; // of 90
        for (const i of angles) for (const o of angles) for (let phi = 0; phi <= 180; phi += 20) rows.push(`${i},0,${o},${phi},.2,.2,.2`);
        writeFileSync(csv, rows.join("\n") + "\n");
        await add([["part.csv", readFileSync(csv)]], "ref");
        await evaluate("setPair({test: 'lambert:kd=.5'})");
        await expectPair("part.csv", "lambert:kd=.5", jodOf(csv, "lambert:kd=.5"));
        await until("/^part.csv has no value for directions of 0[.][0-9]+ % of the light, which is missing in the picture.$/.test(document.getElementById('holes').textContent)");
        await evaluate("setPair({ref: 'lambert:kd=.3'})");
        await until("document.getElementById('holes').textContent === '' && !document.querySelector('.earlier')");
        rmSync(folder, {recursive: true});
    },
    async limits() {
        await drop("body", [["bomb.zip", zip("zeros.csv", Buffer.alloc((1 << 29) + 1), 10).toString("base64")]]);
        await until("document.getElementById('fault').textContent === \"bomb.zip: cannot be unpacked: with 'zeros.csv' the unpacked files have more than 512 MiB\"");
        await drop("body", [["fine.zip", zip("paint.gltf", GLTF, 1 << 30).toString("base64")]]);
        await until("chosen.ref === 'fine.zip/paint.gltf:a'");
        const head = Buffer.from("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xff\xff\0\0\xff\xff\x08\x06\0\0\0", "latin1");
        await add([["wide/base_color.png", head]]);
        assert.match(await text("fault"), /^wide.base_color.png: with 65535 x 65535 pixels the files have more than 1024 MiB/);
        await evaluate("setPair({ref: 'sgd:nickel', test: 'ward:nickel'})");
    },
    async turning() {
        await until("!drawing", 300);
        const pixels = "document.getElementById('picture-ref').toDataURL()";
        await evaluate("document.getElementById('turn').click()");
        await until("frames.size > 1", 300);
        const first = await evaluate(pixels);
        await until(`${pixels} !== ${JSON.stringify(first)}`, 300);
        await evaluate("document.getElementById('turn').click()");
        await evaluate("(() => { const s = document.getElementById('split'); s.value = 20; s.dispatchEvent(new Event('input')); })()");
        assert.equal(await evaluate("getComputedStyle(document.getElementById('compare')).getPropertyValue('--split')"), "20%");
    },
    async parity() {
        const pairs = makePairs(500), folder = mkdtempSync(join(tmpdir(), "nqm-page-"));
        writeFileSync(join(folder, "pairs.csv"), listText(pairs));
        const expected = readJods(execFileSync(tool, ["batch", join(folder, "pairs.csv")], {encoding: "utf8", maxBuffer: 1 << 28}));
        rmSync(folder, {recursive: true});
        const found = await evaluate(`scorer.call("scoreMany", ${JSON.stringify(pairs)}).then((list) => list.map(({jod, low, high}) => [jod, low, high]))`);
        const worst = Math.max(...found.flatMap((row, i) => row.map((x, k) => Math.abs(x - expected[i][k]))));
        console.log(`largest difference from nqm batch over ${pairs.length} pairs: ${worst.toExponential(2)} JOD`);
        assert(worst < 1e-4);
    },
    async speed() {
        const times = await evaluate(`(async () => {
            const times = [];
            for (let i = 0; i < 20; ++i) {
                const begin = performance.now();
                await scorer.call("score", "sgd:nickel", "ggx:kd=0.1;f0=0.5;alpha=0." + (101 + i));
                times.push(performance.now() - begin);
            }
            return times.sort((a, b) => a - b);
        })()`);
        console.log("a further score:", times[10].toFixed(1), "ms (median),", times[19].toFixed(1), "ms at most");
    },
    async network() {
        const refused = await evaluate("fetch('https://example.com/').then(() => false, () => true)");
        assert(refused && browser.console.some((line) => /Content Security Policy/.test(line)));
        browser.console.length = 0;
    },
    async narrow() {
        await open("", 400, 800, true);
        assert(await evaluate("document.documentElement.scrollWidth <= 400"), `the page is ${await evaluate("document.documentElement.scrollWidth")} pixels wide`);
        await shot("narrow");
        const named = await evaluate("[...document.querySelectorAll('button, input:not([type=file]), select, textarea, canvas')].filter((e) => !e.closest('[hidden]') && !(e.getAttribute('aria-label') || e.labels?.length || e.textContent.trim())).map((e) => e.outerHTML)");
        assert.deepEqual(named, []);
    },
};

let failed = 0;
try {
    for (const [name, test] of Object.entries(tests)) {
        const begin = Date.now();
        if (only.length && !only.includes(name)) continue;
        try {
            await test();
            console.log(`ok ${name} (${((Date.now() - begin) / 1000).toFixed(1)} s)`);
        } catch (error) {
            ++failed;
            console.log(`FAILED ${name}: ${error.stack}`);
        }
    }
    if (browser.console.length) {
        ++failed;
        console.log("the browser reports:", browser.console.slice(0, 5).join("\n"));
    }
} finally {
    await browser.close();
}
process.exit(failed ? 1 : 0);
