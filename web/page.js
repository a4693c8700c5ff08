// SPDX-License-Identifier: MIT
//
// The page: two materials, their score, pictures and maps; translations, shaders, and a table of more than two. Everything is computed in two
// workers: one scores, one draws and fits, so that scores never wait for pictures. Both score a table.
import {drawMap, drawParts, drawScale, drawSlices, make} from "./charts.js";
import {setUpCombo} from "./combo.js";
import {candidates, mapFolders, readFiles, readPaste} from "./files.js";
import {complete, interval, jod2, makeHash, markdown, people, quote, readHash} from "./text.js";

const $ = (id) => document.getElementById(id);
const EXAMPLE = {ref: "sgd:gold-metallic-paint", test: "gltf:base_color=0.0046,0,0;metallic=0;roughness=0.444;ior=5;specular=0.41;specular_color=1,0.703,0.222"};
const EXAMPLE_GLSL = `::begin parameters
float roughness 0.02 1 0.33
color baseColor 0.62 0.56 0.47
float diffuse 0 0.1 0.01
::end parameters

const float PI = 3.14159265358979;

vec3 BRDF(vec3 L, vec3 N, vec3 V, vec3 X, vec3 Y) {
    vec3 H = normalize(L + V);
    float a2 = pow(roughness, 4.0), NL = dot(N, L), NV = dot(N, V), NH = dot(N, H);
    float d = NH * NH * (a2 - 1.0) + 1.0;
    float D = a2 / (PI * d * d);
    float G = 0.5 / (NL * sqrt(NV * NV * (1.0 - a2) + a2) + NV * sqrt(NL * NL * (1.0 - a2) + a2));
    vec3 F = baseColor + (1.0 - baseColor) * pow(1.0 - dot(L, H), 5.0);
    return vec3(diffuse / PI) + D * G * F;
}
`;

// ---- workers --------------------------------------------------------------------------------------------------------

const parsed = new Promise((resolve) => addEventListener("DOMContentLoaded", resolve)); // the page, with the data at its end

class Caller {
    constructor(url) {
        this.url = url;
        this.waiting = new Map();
        this.next = 1;
    }
    /** At the first call. */
    start() {
        this.started ??= this.begin();
        return this.started;
    }
    async begin() {
        this.worker = new Worker(this.url);
        this.worker.onmessage = ({data: {id, value, error, progress}}) => {
            const call = this.waiting.get(id);
            if (progress !== undefined) return call.onProgress?.(progress);
            this.waiting.delete(id);
            if (error) call.reject(Object.assign(new Error(error.message), error));
            else call.resolve(value);
        };
        this.worker.onerror = (event) => showFault(`The worker of the page failed: ${event.message}`);
        await parsed;
        return this.send(undefined, "start", [$("data").textContent]);
    }
    call(fn, ...args) {
        return this.callWith(undefined, fn, ...args);
    }
    async callWith(onProgress, fn, ...args) {
        await this.start();
        return this.send(onProgress, fn, args);
    }
    send(onProgress, fn, args) {
        return new Promise((resolve, reject) => {
            this.waiting.set(this.next, {resolve, reject, onProgress});
            this.worker.postMessage({id: this.next++, fn, args});
        });
    }
}

let scorer, artist, names = {presets: [], models: [], targets: []};
/** For both workers, which answer calls in their order; only the scorer is waited for. */
function both(fn, ...args) {
    artist.call(fn, ...args).catch(() => {});
    return scorer.call(fn, ...args);
}

// ---- state ----------------------------------------------------------------------------------------------------------

const chosen = {ref: "", test: ""}; // arguments of nqm_brdf_open(), or glsl:NAME
const slots = Object.fromEntries(["ref", "test"].map((member) => [member, {
    root: document.querySelector(`[data-member="${member}"]`), input: $(`${member}-input`), list: $(`${member}-list`), about: $(`${member}-about`),
    members: document.querySelector(`[data-member="${member}"] .members`), select: $(`${member}-members`), materials: [],
}]));
const textured = new Set(); // arguments of materials with image maps
const dropped = []; // arguments of the table
let score = null, turn = 0, shaderText = "";

function showFault(message) {
    $("fault").hidden = !message;
    $("fault").textContent = message ?? "";
}

function describe(member, info) {
    const {about, input} = slots[member];
    input.setAttribute("aria-invalid", "false");
    about.textContent = !info ? "" : info.format === "callback" ? "GLSL" : [info.format, info.isotropic ? "" : "not isotropic by construction", info.spec && info.spec !== info.name ? info.spec : info.layout]
        .filter(Boolean).join(" · ");
    about.title = about.textContent;
}

// ---- the score ------------------------------------------------------------------------------------------------------

let round = 0; // of the last change; older answers are dropped

const hide = (selector, isHidden) => document.querySelectorAll(selector).forEach((element) => element.classList.toggle("earlier", isHidden));

/** Use these arguments and score them. What belongs to an earlier pair is hidden until there is its like of this one. */
async function setPair(change) {
    const changed = Object.keys(change).filter((member) => change[member] !== chosen[member]);
    Object.assign(chosen, change);
    for (const member of ["ref", "test"]) {
        const {input, select, members} = slots[member], options = [...select.options].map(({value}) => value);
        if (document.activeElement !== input || member in change) input.value = chosen[member];
        if (options.includes(chosen[member])) select.value = chosen[member];
        members.hidden = options.length < 2 || !options.includes(chosen[member]);
    }
    const mine = ++round;
    showFault(null);
    document.body.classList.toggle("textured", isTextured());
    if (changed.includes("ref")) $("translated").replaceChildren();
    if (changed.length) {
        for (const member of changed) describe(member, null);
        showScore(null, "Computing…");
        hide(".pictures, .difference, .where", true);
    }
    document.querySelector(".result").classList.add("stale");
    const infos = {};
    for (const member of ["ref", "test"]) {
        if (!chosen[member]) {
            describe(member, null);
            continue;
        }
        try {
            infos[member] = hasMaps(chosen[member]) ? {name: chosen[member], format: "image maps", isotropic: true} : await scorer.call("open", chosen[member]);
            if (mine !== round) return;
            describe(member, infos[member]);
        } catch (error) {
            if (mine !== round) return;
            describe(member, null);
            slots[member].input.setAttribute("aria-invalid", "true");
            showFault([$("fault").textContent, error.message].filter(Boolean).join("\n"));
        }
    }
    const hash = makeHash(...["ref", "test"].map((member) => linkable(infos[member] ?? {name: chosen[member]})));
    if (hash !== location.hash) history.replaceState(null, "", hash);
    if (!infos.ref || !infos.test) return showScore(null);
    try {
        const found = await scorer.call(isTextured() ? "scoreTextures" : "score", chosen.ref, chosen.test);
        if (mine !== round) return;
        showScore(found);
    } catch (error) {
        if (mine !== round) return;
        showFault(error.message);
        return showScore(null);
    }
    if (isTextured()) return drawHeat(score.texture);
    drawPictures();
    await showDetails(mine);
}

const hasMaps = (argument) => /^(ignore:[^:]*:)?maps:/.test(argument) || textured.has(argument.replace(/^ignore:[^:]*:/, ""));
const isTextured = () => hasMaps(chosen.ref) || hasMaps(chosen.test);

function drawHeat({heat: {width, height, pixels}, end}) {
    Object.assign($("picture-difference"), {width, height}).getContext("2d").putImageData(new ImageData(pixels, width, height), 0, 0);
    $("difference-end").textContent = end < 10 ? end.toPrecision(2) : Math.round(end);
    hide(".difference", false);
}

/** What is said of a pair with image maps. */
const textureRemarks = ({far, worst, below9, width, height, n_scored, blame}) => [
    `${width} × ${height} texels, ${n_scored} pairs of them scored; the worst 5 % have ${jod2(worst)} JOD at most, ${(100 * below9).toFixed(0)} % are below 9`,
    ...(far === null ? [] : [`from far away: ${jod2(far)} JOD`]),
    ...blame.filter(({jod}) => jod < 9.995).map(({key, jod, mistake}) => `${key} alone: ${jod2(jod)} JOD${mistake ? ` (${mistake})` : ""}`)];

// A link has the spec of a material file; a measured file cannot be in it.
const linkable = ({name, spec}) => (spec && !isSpec(name) ? spec : name);
const isSpec = (name) => names.models.some((model) => name.startsWith(model.name + ":")) || names.presets.includes(name) || /^(perturb|between|rotate|tilt):/.test(name);

/** found: null without a score; `verdict` says why. */
function showScore(found, verdict = chosen.ref && chosen.test ? "No score" : "Choose two materials") {
    score = found;
    document.querySelector(".result").classList.toggle("stale", !found);
    $("jod").textContent = found ? jod2(found.jod) : "–";
    $("interval").textContent = found ? interval(found) : "";
    $("verdict").textContent = found ? found.verdict : verdict;
    $("words").textContent = found ? (found.words || "") : "";
    $("people").textContent = !found ? "" : found.identical ? "Both are equal at all directions that are compared."
        : `${people(found.prefer_reference).replace(/^./, (c) => c.toUpperCase())} of people would say that the reference looks better. ΔE ITP ${found.delta_e === null ? "–" : found.delta_e.toFixed(1)}${found.apart[0] === null ? "" : `; seen apart ${jod2(found.apart[0])} JOD`}${found.anisotropy > 0 ? "; anisotropic" : ""}.`;
    $("remarks").replaceChildren(...[...(found?.texture ? textureRemarks(found.texture) : []), ...(found?.remarks ?? [])].map((text) => make("li", {}, text)));
    drawScale($("scale"), found);
    if (found) {
        drawParts($("parts"), found);
        performance.mark("nqm-score");
    }
    showShare();
    document.title = found ? `${jod2(found.jod)} JOD – nqm` : "nqm – drop two materials";
}

async function showDetails(mine) {
    const {slices, map, costs} = await scorer.call("details", chosen.ref, chosen.test);
    if (mine !== round) return;
    hide(".where", false);
    drawSlices($("slices"), slices);
    drawMap($("map"), map);
    $("costs").replaceChildren(...costs.slice(0, 8).map(([h, d, p, share, a, b]) => make("tr", {},
        ...[`${h.toFixed(1)}°`, `${d.toFixed(0)}°`, `${p.toFixed(0)}°`, `${(100 * share).toFixed(1)} %`, a.toPrecision(3), b.toPrecision(3)].map((x) => make("td", {class: "n"}, x)))));
}

// ---- pictures -------------------------------------------------------------------------------------------------------

const SIZE = 180, PREVIEW = 64, TURN_SIZE = 80, STEP = 10, FRAME_MS = 70;
let drawing = false, wanted = false;
const frames = new Map(); // of the pair and light that turn now, by angle

// Enlarged and cut out by a smooth circle: the pixels at the edge of the sphere are only in or out.
function paint({images, end, valid}, size) {
    const small = new OffscreenCanvas(size, size), full = 360, middle = 4 * size * (size >> 1);
    let opaque = 0;
    for (let x = 0; x < size; ++x) opaque += images[0][middle + 4 * x + 3] > 127;
    ["picture-ref", "picture-test", "picture-difference"].forEach((id, i) => {
        const context = Object.assign($(id), {width: full, height: full}).getContext("2d");
        small.getContext("2d").putImageData(new ImageData(images[i], size, size), 0, 0);
        context.imageSmoothingQuality = "high";
        context.beginPath();
        context.arc(full / 2, full / 2, (full * (opaque - 1.6)) / size / 2, 0, 7);
        context.clip();
        context.drawImage(small, 0, 0, full, full);
    });
    $("difference-end").textContent = end;
    $("holes").textContent = ["ref", "test"].map((member, i) => valid[i] < 1 ? `${chosen[member]} has no value for directions of ${Number((100 * (1 - valid[i])).toPrecision(3))} % of the light, which is missing in the picture.` : "").join(" ").trim();
    hide(".pictures, .difference", false);
}

const isTurning = () => $("turn").getAttribute("aria-pressed") === "true";

/** Frames are kept: the second revolution is smooth. */
async function drawTurned(light) {
    const mine = round, of = `${mine} ${light}`, begin = performance.now(), at = (turn + STEP) % 360;
    if (frames.of !== of) frames.clear();
    frames.of = of;
    const frame = frames.get(at) ?? await artist.call("pictures", chosen.ref, chosen.test, {light, size: TURN_SIZE, supersample: 1, turn: at || 360});
    if (mine !== round) return;
    frames.set(turn = at, frame);
    paint(frame, TURN_SIZE);
    await new Promise((resolve) => setTimeout(resolve, Math.max(FRAME_MS - (performance.now() - begin), 0)));
}

/** Draw the pair that is chosen now, if it has a score and no maps; a request during a drawing is done after it. */
async function drawPictures() {
    wanted = true;
    if (drawing) return;
    drawing = true;
    while (wanted && score && !isTextured()) {
        wanted = false;
        const light = document.querySelector("[name=light]:checked").value, mine = round;
        try {
            if (isTurning()) {
                await drawTurned(light);
                wanted = true;
                continue;
            }
            for (const size of isShader() ? [PREVIEW] : [PREVIEW, SIZE]) { // a shader is called for each point
                if (wanted || mine !== round) break;
                const found = await artist.call("pictures", chosen.ref, chosen.test, {light, size, supersample: 1});
                if (!wanted && mine === round) paint(found, size);
            }
        } catch (error) {
            if (!wanted && mine === round) showFault(error.message);
        }
    }
    drawing = false;
    performance.mark("nqm-pictures");
    if (score) document.body.dataset.pictures = `${chosen.ref} ${chosen.test}`;
}

// ---- files ----------------------------------------------------------------------------------------------------------

/** The arguments that a file stands for: {argument, label, refusal}. */
async function listMaterials(path) {
    try {
        const materials = await scorer.call("materials", path);
        return materials.map(({name, refusal, n_maps}) => {
            const argument = materials.length > 1 ? `${path}:${name}` : path;
            textured[n_maps ? "add" : "delete"](argument);
            return {argument, label: name, refusal: !n_maps && refusal && `${path}: ${name}: ${refusal}`};
        });
    } catch (error) {
        try {
            textured.delete(path);
            await scorer.call("open", path);
            return [{argument: path, label: path, refusal: null}];
        } catch (other) {
            return [{argument: path, label: path, refusal: other.message}];
        }
    }
}

let adding = Promise.resolve(); // drops are taken one after the other

/** Take files for a slot; without one, for the slots and the table. */
function addFiles(files, member) {
    return adding = adding.then(() => addDrop(files, member)).catch((error) => showFault(error.message));
}

async function addDrop(files, member) {
    if (!files.length) return;
    const before = await both("addFiles", files, [...Object.values(chosen), ...dropped]);
    const found = [], refused = [];
    const folders = mapFolders(files).map((folder) => before + folder);
    for (const folder of folders) {
        textured.add(folder);
        found.push({argument: folder, label: folder, refusal: null});
    }
    for (const path of folders.length ? [] : candidates(files)) for (const item of await listMaterials(before + path)) (item.refusal ? refused : found).push(item);
    const fault = refused.map(({refusal}) => refusal).join("\n");
    if (found.length) {
        const next = isExample("ref") ? "ref" : "test";
        for (const slot of member || found.length < 2 ? [member ?? next] : ["ref", "test"]) showMembers(slot, found);
        setPair(member || found.length < 2 ? {[member ?? next]: found[0].argument} : {ref: found[0].argument, test: found[1].argument});
    }
    if (fault) showFault(fault);
    const plain = found.map(({argument}) => argument).filter((argument) => !textured.has(argument));
    if (plain.length > 2 || (dropped.length && !member)) addRows(plain);
}

const isExample = (member) => chosen[member] === EXAMPLE[member];

function showMembers(member, found) {
    const {select} = slots[member];
    select.replaceChildren(...found.map(({argument, label}) => make("option", {value: argument}, label)));
}

async function takeText(text, member) {
    const paste = readPaste(text);
    if (paste.glsl) return useGlsl(paste.glsl);
    if (paste.file) return addFiles([paste.file], member);
    return setPair({[member ?? (isExample("ref") ? "ref" : "test")]: paste.spec});
}

function setUpFiles() {
    let target = null;
    const slotOf = (node) => node.closest?.(".slot")?.dataset.member ?? null;
    const take = async (source, member) => {
        try {
            await addFiles(await readFiles(source), member);
        } catch (error) {
            showFault(error.message);
        }
    };
    for (const button of document.querySelectorAll(".choose"))
        button.addEventListener("click", () => {
            target = slotOf(button);
            $("file").value = "";
            $("file").click();
        });
    $("file").addEventListener("change", () => take($("file").files, target));
    addEventListener("dragover", (event) => {
        event.preventDefault();
        $("drop").hidden = false;
        document.querySelectorAll(".slot").forEach((slot) => slot.classList.toggle("over", slot.contains(event.target)));
    });
    const leave = () => {
        $("drop").hidden = true;
        document.querySelectorAll(".slot").forEach((slot) => slot.classList.remove("over"));
    };
    addEventListener("dragleave", (event) => event.relatedTarget ?? leave());
    addEventListener("drop", (event) => {
        event.preventDefault();
        leave();
        const text = event.dataTransfer.getData("text/plain");
        if (event.dataTransfer.files.length) take(event.dataTransfer, slotOf(event.target));
        else if (text) takeText(text, slotOf(event.target));
    });
    addEventListener("paste", (event) => {
        const member = slotOf(event.target), text = event.clipboardData.getData("text/plain");
        if (event.clipboardData.files.length) take(event.clipboardData, member);
        else if (!text || event.target.id === "glsl" || (event.target.matches?.("input") && readPaste(text).spec !== undefined)) return;
        else takeText(text, member);
        event.preventDefault();
    });
    for (const member of ["ref", "test"]) slots[member].select.addEventListener("change", () => setPair({[member]: slots[member].select.value}));
}

// ---- the table ------------------------------------------------------------------------------------------------------

const SHOWN = 100;
let rows = [], shown = SHOWN, batch = 0;

/** Score every pair of these and the earlier arguments, worst first; the page stays usable. */
async function addRows(list) {
    const mine = ++batch;
    for (const argument of list) if (!dropped.includes(argument)) dropped.push(argument);
    const pairs = dropped.flatMap((ref, i) => dropped.slice(i + 1).map((test) => [ref, test])), begin = performance.now();
    rows = [];
    shown = SHOWN;
    $("table").hidden = false;
    let next = 0;
    const work = async (worker) => {
        while (next < pairs.length && mine === batch) {
            const part = pairs.slice(next, (next += 64)), scores = await worker.call("scoreMany", part);
            if (mine !== batch) return;
            rows.push(...scores.map((found, k) => ({ref: part[k][0], test: part[k][1], score: found})));
            rows.sort((a, b) => (a.score.jod ?? -1) - (b.score.jod ?? -1));
            $("table-about").textContent = `${dropped.length} materials, ${rows.length} of ${pairs.length} pairs`;
            showRows();
        }
    };
    await Promise.all([work(scorer), work(artist)]);
    if (mine !== batch) return;
    $("table-about").textContent = `${dropped.length} materials, ${pairs.length} pairs, ${((performance.now() - begin) / 1000).toFixed(1)} s`;
    document.body.dataset.pairs = pairs.length;
    showShare();
}

function showRows() {
    $("rows").replaceChildren(...rows.slice(0, shown).map(({ref, test, score: found}) => make("tr", {class: ref === chosen.ref && test === chosen.test ? "chosen" : ""},
        make("td", {class: "n"}, make("button", {"aria-label": `Show ${ref} and ${test}`, onclick: () => setPair({ref, test}).then(showRows)}, found.error === undefined ? jod2(found.jod) : "–")),
        make("td", {}, ref), make("td", {}, test), make("td", {}, found.error ?? found.words))));
    $("more").hidden = rows.length <= shown;
    $("more").textContent = `Show ${Math.min(rows.length - shown, 500)} more`;
}

// ---- translation ----------------------------------------------------------------------------------------------------

const EXTENSIONS = {gltf: ".gltf", principled: ".xml", "rough-conductor": ".xml", "rough-plastic": ".xml", "pbrt-conductor": ".pbrt"};

async function translate() {
    const {ref} = chosen, target = $("target").value, name = (chosen.ref.split("/").pop() ?? "").replace(/\.[^.:]*/, "").replace(/\W+/g, "_").slice(0, 40) || "material";
    const path = `${name}-${target}${EXTENSIONS[target] ?? ".mtlx"}`, progress = $("fitting");
    $("translate").disabled = true;
    progress.hidden = false;
    progress.removeAttribute("value");
    try {
        const {spec, score: found, dropped: lost, data} = await artist.callWith((done) => (progress.value = done), "translate", ref, target, name, path);
        const link = make("a", {href: URL.createObjectURL(new Blob([data])), download: path}, `Download ${path}`);
        if (ref === chosen.ref) $("translated").replaceChildren(make("p", {}, make("strong", {}, `${jod2(found.jod)} JOD`), ` ${interval(found)} ${found.verdict}${lost ? `; dropped: ${lost}` : ""}`),
            make("p", {}, link, " ", make("button", {type: "button", onclick: () => setPair({test: spec})}, "Use as approximation")), make("pre", {tabindex: 0}, spec));
    } catch (error) {
        if (ref === chosen.ref) $("translated").replaceChildren(make("p", {}, error.message));
    }
    progress.hidden = true;
    $("translate").disabled = false;
}

// ---- sharing --------------------------------------------------------------------------------------------------------

const isShader = () => Object.values(chosen).some((name) => name.startsWith("glsl:"));
const shareTexts = { // of pairs with a score
    link: () => (isShader() || !Object.values(readHash(location.hash) ?? {"": ""}).every(isSpec) ? null : location.href),
    command: () => (isShader() ? null : `nqm score ${quote(chosen.ref)} ${quote(chosen.test)}`),
    markdown: () => markdown(rows.length ? rows : [{...chosen, score}]),
};
const shareFaults = {link: "A link holds specs: measured files and shaders are only on this page.", command: "The command line reads no shaders."};

function showShare() {
    $("share").textContent = score ? shareTexts.command() ?? shareFaults.command : "";
}

async function copy(kind) {
    const text = score || (kind === "markdown" && rows.length) ? shareTexts[kind]() : "";
    $("share").textContent = text === "" ? "This pair has no score." : text ?? shareFaults[kind];
    $("copied").textContent = "";
    if (!text) return;
    try {
        await navigator.clipboard.writeText(text);
        $("copied").textContent = "Copied.";
    } catch {
        getSelection().selectAllChildren($("share"));
        $("copied").textContent = document.execCommand("copy") ? "Copied." : "Press Ctrl+C to copy the selected text.";
    }
}

// ---- shaders --------------------------------------------------------------------------------------------------------

const SHADER = "glsl:shader";

async function useGlsl(text) {
    $("glsl").value = text;
    $("glsl-fault").hidden = true;
    try {
        const parameters = await both("glsl", SHADER, text);
        if (text !== shaderText) showSliders(parameters);
        else await both("setGlsl", SHADER, sliderValues());
        shaderText = text;
        await setPair({test: SHADER});
    } catch (error) {
        $("glsl-fault").hidden = false;
        $("glsl-fault").textContent = error.message;
    }
}

const sliderValues = () => Object.fromEntries([...$("sliders").children].map((label) => [label.dataset.name, label.read()]));
const hex = (rgb) => "#" + rgb.map((x) => Math.round(255 * Math.min(Math.max(x, 0), 1)).toString(16).padStart(2, "0")).join("");

/** Colours are linear; the field shows them as they are, without a transfer curve. */
function showSliders(parameters) {
    let waiting = false;
    const changed = async () => {
        if (waiting) return;
        waiting = true;
        await both("setGlsl", SHADER, sliderValues());
        waiting = false;
        setPair({test: SHADER});
    };
    $("sliders").replaceChildren(...parameters.map(({type, name, low, high, value}) => {
        const output = make("output", {}, type === "float" ? String(value) : "");
        const input = type === "float" ? make("input", {type: "range", min: low, max: high, step: (high - low) / 200, value})
            : type === "color" ? make("input", {type: "color", value: hex(value)}) : make("input", {type: "checkbox", ...(value ? {checked: ""} : {})});
        const label = make("label", {"data-name": name}, name, type === "float" ? output : input, ...(type === "float" ? [input] : []));
        label.read = () => (type === "float" ? Number(input.value) : type === "color" ? [1, 3, 5].map((i) => parseInt(input.value.slice(i, i + 2), 16) / 255) : input.checked);
        input.addEventListener("input", () => {
            output.textContent = type === "float" ? Number(input.value).toPrecision(3) : "";
            changed();
        });
        return label;
    }));
}

// ---- start ----------------------------------------------------------------------------------------------------------

async function begin() {
    performance.mark("nqm-begin");
    drawScale($("scale"), null);
    $("glsl").value = EXAMPLE_GLSL;
    const url = URL.createObjectURL(new Blob([$("worker").textContent], {type: "text/javascript"}));
    for (const member of ["ref", "test"])
        setUpCombo(slots[member].input, slots[member].list, {
            complete: (text) => complete(text, names),
            // A spec is scored while it is typed, when its last key has a value.
            isWhole: (text) => names.presets.includes(text) || (isSpec(text) && /[:;][^:;=]+=[^:;=]*[\w.)]$/.test(text)),
            take: (text) => text !== chosen[member] && setPair({[member]: text}),
        });
    setUpFiles();
    document.querySelector(".swap").addEventListener("click", () => setPair({ref: chosen.test, test: chosen.ref}));
    $("split").addEventListener("input", () => $("compare").style.setProperty("--split", `${$("split").value}%`));
    document.querySelectorAll("[name=light]").forEach((input) => input.addEventListener("change", drawPictures));
    $("turn").addEventListener("click", () => {
        $("turn").setAttribute("aria-pressed", String(!isTurning()));
        drawPictures();
    });
    $("translate").addEventListener("click", translate);
    $("glsl-use").addEventListener("click", () => useGlsl($("glsl").value));
    $("more").addEventListener("click", () => {
        shown += 500;
        showRows();
    });
    $("table-clear").addEventListener("click", () => {
        ++batch;
        dropped.length = rows.length = 0;
        $("table").hidden = true;
    });
    document.querySelectorAll("[data-copy]").forEach((button) => button.addEventListener("click", () => copy(button.dataset.copy)));
    addEventListener("hashchange", () => readHash(location.hash) && setPair(readHash(location.hash)));
    scorer = new Caller(url);
    artist = new Caller(url);
    try {
        names = await scorer.start();
    } catch (error) {
        return showFault(`nqm does not start in this browser: ${error.message}`);
    }
    $("target").replaceChildren(...names.targets.filter((name) => !["openpbr", "usd"].includes(name)).map((name) => make("option", {}, name)));
    $("about").append(` nqm ${names.version}, model “default”, ${names.presets.length} presets.`);
    await setPair(readHash(location.hash) ?? EXAMPLE);
}

begin();
