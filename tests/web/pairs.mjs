// SPDX-License-Identifier: MIT
// pairs.mjs - pairs of specs, the same each time: presets with presets, with distorted copies and with analytic and
// shading models, a tenth of them anisotropic.
let state = 20240607;
const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
const between = (low, high) => (low + (high - low) * random()).toPrecision(5);
const of = (list) => list[Math.floor(random() * list.length)];
const MATERIALS = ["nickel", "chrome", "alum-bronze", "blue-rubber", "black-obsidian", "cherry-235", "gold-paint", "pvc", "steel",
    "teflon", "white-paint", "yellow-plastic", "red-fabric", "silver-metallic-paint", "polyethylene", "brass", "green-latex"];
const preset = () => `${of(["sgd", "abc", "ward", "ward-duer", "smooth", "cook-torrance", "ashikhmin-shirley"])}:${of(MATERIALS)}`;
const colour = () => [0, 1, 2].map(() => between(0.02, 0.9)).join(",");
const tests = [
    () => preset(),
    (ref) => `perturb:gloss=${between(0.5, 1.5)};of=${ref}`,
    (ref) => `perturb:gloss=${between(0.97, 1.03)};tint=${between(0.97, 1.03)},1,1;of=${ref}`,
    (ref) => `between:t=${between(0, 1)};with=(${preset()});of=${ref}`,
    () => `ggx:kd=${colour()};f0=${colour()};alpha=${between(0.02, 0.8)}`,
    () => `gltf:base_color=${colour()};roughness=${between(0.1, 1)};metallic=${of([0, 1])}`,
    () => `open-pbr:base_color=${colour()};specular_roughness=${between(0.1, 1)};coat_weight=${of([0, 0.5, 1])}`,
    () => `principled:base_color=${colour()};roughness=${between(0.2, 1)};metallic=${between(0, 1)}`,
    () => `gltf:base_color=${colour()};roughness=${between(0.2, 0.8)};metallic=1;anisotropy_strength=${between(0.1, 0.9)}`,
];
export function makePairs(n) {
    state = 20240607;
    return Array.from({length: n}, () => {
        const ref = preset();
        return [ref, of(tests)(ref)];
    });
}

/** The list for `nqm batch`. */
export const listText = (pairs) => ["reference,test", ...pairs.map((pair) => pair.map((x) => `"${x}"`).join(","))].join("\n") + "\n";

/** [[jod, low, high]] of the CSV that it writes. */
export function readJods(csv) {
    const fields = (line) => [...line.matchAll(/("([^"]*)"|[^,]*)(,|$)/g)].map(([, plain, quoted]) => quoted ?? plain);
    const [header, ...rows] = csv.trim().split("\n").map(fields), at = ["jod", "jod_low", "jod_high"].map((name) => header.indexOf(name));
    return rows.map((row) => at.map((i) => Number(row[i])));
}
