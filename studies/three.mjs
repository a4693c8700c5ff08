// SPDX-License-Identifier: MIT
// three.mjs THREE_BUILD [NQM] - does three.js implement glTF 2.0? Its MeshPhysicalMaterial at the kits of `nqm conform gltf`, as it is and without its
// energy compensation; a table in Markdown. THREE_BUILD: the folder `build` of its npm package. Needs node and Chromium.
import {execFileSync, spawnSync} from "node:child_process";
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {startBrowser} from "../tests/web/browser.mjs";

const [, , build, tool = new URL("../build/nqm", import.meta.url).pathname] = process.argv;
const CORE = "base_color,metallic,roughness";
const GROUPS = {"metallic-roughness": CORE, "ior, specular": `${CORE},ior,specular,specular_color`, anisotropy: `${CORE},anisotropy_strength,anisotropy_rotation`,
    "clear coat": `${CORE},clearcoat,clearcoat_roughness`, sheen: `${CORE},sheen_color,sheen_roughness`,
    iridescence: `${CORE},iridescence,iridescence_ior,iridescence_thickness`};
const folder = mkdtempSync(join(tmpdir(), "nqm-three-"));

/** [{values: {key: number or [r, g, b]}, pairs: [[light, viewer]]}] */
function makeKit(keys) {
    execFileSync(tool, ["conform", "gltf", "--keys", keys, "--directions", join(folder, "kit.csv")], {stdio: "ignore"});
    const [head, ...lines] = readFileSync(join(folder, "kit.csv"), "utf8").trim().split("\n"), sets = [];
    for (const line of lines) {
        const row = Object.fromEntries(line.split(",").map((x, i) => [head.split(",")[i], Number(x)])), values = {};
        for (const [name, x] of Object.entries(row)) /_[rgb]$/.test(name) ? (values[name.slice(0, -2)] ??= []).push(x) : (values[name] = x);
        const set = (sets[row.set - 1] ??= {values, pairs: []});
        set.pairs.push(["light", "viewer"].map((w) => ["x", "y", "z"].map((c) => row[`${w}_${c}`])));
    }
    return sets;
}

// In the page: each pair is a square of 2 x 2 pixels that faces an orthographic camera, with the normal and tangent that turn the viewer into the view. The
// light of a square comes from an attribute; nothing else of the shader is changed.
function prepare() {
    const WIDTH = 96, dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const renderer = new THREE.WebGLRenderer(), camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 10);
    const {lights_fragment_begin: lights, lights_physical_pars_fragment: physical} = THREE.ShaderChunk;
    const LIGHT = "getDirectionalLightInfo( directionalLight, directLight );", COMPENSATION = " * material.multiScatteringCompensation";
    if (!lights.includes(LIGHT) || !physical.includes(COMPENSATION)) throw new Error("the shaders of this three.js are others");
    camera.position.z = 5;
    window.draw = ({values: v, pairs}, isCompensated) => {
        const height = 2 * Math.ceil(pairs.length / (WIDTH / 2)), lists = {position: [], normal: [], tangent: [], light: []}, index = [];
        pairs.forEach(([light, viewer], k) => {
            let e = Math.abs(viewer[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
            e = e.map((x, i) => x - dot(e, viewer) * viewer[i]);
            e = e.map((x) => x / Math.hypot(...e));
            const f = cross(viewer, e), turn = (w) => [dot(e, w), dot(f, w), dot(viewer, w)];
            for (const [i, j] of [[0, 0], [2, 0], [2, 2], [0, 2]]) {
                lists.position.push(2 * ((2 * k) % WIDTH + i) / WIDTH - 1, 2 * (2 * Math.floor(2 * k / WIDTH) + j) / height - 1, 0);
                lists.normal.push(...turn([0, 0, 1]));
                lists.tangent.push(...turn([1, 0, 0]), 1);
                lists.light.push(...turn(light));
            }
            index.push(4 * k, 4 * k + 1, 4 * k + 2, 4 * k, 4 * k + 2, 4 * k + 3);
        });
        const geometry = new THREE.BufferGeometry(), color = (rgb) => new THREE.Color().setRGB(...rgb, THREE.LinearSRGBColorSpace);
        for (const [name, list] of Object.entries(lists)) geometry.setAttribute(name, new THREE.Float32BufferAttribute(list, name === "tangent" ? 4 : 3));
        geometry.setIndex(index);
        const options = {color: color(v.base_color), metalness: v.metallic, roughness: v.roughness, ior: v.ior, specularIntensity: v.specular,
            specularColor: v.specular_color && color(v.specular_color), clearcoat: v.clearcoat, clearcoatRoughness: v.clearcoat_roughness,
            anisotropy: v.anisotropy_strength, anisotropyRotation: v.anisotropy_rotation, sheenColor: v.sheen_color && color(v.sheen_color),
            sheen: v.sheen_color && Number(Math.max(...v.sheen_color) > 0), sheenRoughness: v.sheen_roughness, iridescence: v.iridescence,
            iridescenceIOR: v.iridescence_ior, iridescenceThicknessMinimum: v.iridescence_thickness, iridescenceThicknessMaximum: v.iridescence_thickness};
        const material = new THREE.MeshPhysicalMaterial(Object.fromEntries(Object.entries(options).filter(([, x]) => x !== undefined)));
        material.customProgramCacheKey = () => String(isCompensated);
        material.onBeforeCompile = (shader) => {
            shader.vertexShader = `attribute vec3 light; varying vec3 vLight;\n${shader.vertexShader.replace("#include <begin_vertex>", "$&\nvLight = light;")}`;
            shader.fragmentShader = `varying vec3 vLight;\n${shader.fragmentShader
                .replace("#include <lights_fragment_begin>", lights.replace(LIGHT, `${LIGHT} directLight.direction = vLight;`))
                .replace("#include <lights_physical_pars_fragment>", isCompensated ? physical : physical.replaceAll(COMPENSATION, ""))}`;
        };
        const mesh = new THREE.Mesh(geometry, material), scene = new THREE.Scene().add(mesh, new THREE.DirectionalLight(0xffffff, 1));
        const target = new THREE.WebGLRenderTarget(WIDTH, height, {type: THREE.FloatType, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter});
        const pixels = new Float32Array(4 * WIDTH * height);
        mesh.frustumCulled = false;
        renderer.setRenderTarget(target);
        renderer.render(scene, camera);
        renderer.readRenderTargetPixels(target, 0, 0, WIDTH, height, pixels);
        [geometry, material, target].forEach((x) => x.dispose());
        return pairs.flatMap(([light], k) => [0, 1, 2].map((c) => pixels[4 * (2 * Math.floor(2 * k / WIDTH) * WIDTH + (2 * k) % WIDTH) + c] / light[2]));
    };
}

const browser = await startBrowser(process.env.CHROMIUM ?? "/usr/bin/chromium");
const source = (name) => JSON.stringify(readFileSync(join(build, name), "utf8"));
await browser.open(`data:text/html,<title>three</title>`);
await browser.evaluate(`(async () => {
    const module = (text) => URL.createObjectURL(new Blob([text], {type: "text/javascript"}));
    window.THREE = await import(module(${source("three.module.js")}.replaceAll("./three.core.js", module(${source("three.core.js")}))));
    (${prepare})();
})()`);
console.log(`three.js ${await browser.evaluate("THREE.REVISION")}\n\n| keys | sets | pass | lowest JOD | without compensation: pass | lowest JOD | mistake named |\n|---|---|---|---|---|---|---|`);
for (const [name, keys] of Object.entries(GROUPS)) {
    const kit = makeKit(keys), cells = [];
    let named;
    for (const isCompensated of [true, false]) {
        const lines = ["r,g,b"];
        for (const set of kit) {
            const f = await browser.evaluate(`draw(${JSON.stringify(set)}, ${isCompensated})`);
            for (let i = 0; i < f.length; i += 3) lines.push(f.slice(i, i + 3).join());
        }
        writeFileSync(join(folder, "values.csv"), lines.join("\n") + "\n");
        const [values, ...more] = [join(folder, "values.csv"), "--keys", keys];
        const result = JSON.parse(spawnSync(tool, ["conform", "gltf", values, ...more, "--json"], {encoding: "utf8"}).stdout);
        named = spawnSync(tool, ["conform", "gltf", values, ...more, "-q"], {encoding: "utf8"}).stdout.trim();
        cells.push(result.results.filter(({jod}) => jod >= 9.99).length, result.lowest_jod.toFixed(2));
    }
    console.log(`| ${name} | ${kit.length} | ${cells.join(" | ")} | ${named} |`);
}
await browser.close();
rmSync(folder, {recursive: true});
