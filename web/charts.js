// SPDX-License-Identifier: MIT
//
// Charts of the page and of the reports of `nqm report`: the scale of JOD, slices, the map, bars.

const SVG = "http://www.w3.org/2000/svg";

export function make(name, attributes = {}, ...children) {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
        if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
        else element.setAttribute(key, value);
    }
    element.append(...children);
    return element;
}

function svg(name, attributes = {}, ...children) {
    const element = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    element.append(...children);
    return element;
}

const VIRIDIS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
function viridis(t) {
    const at = 4 * Math.min(Math.max(t, 0), 1), i = Math.min(Math.floor(at), 3);
    return VIRIDIS[i].map((x, k) => x + (at - i) * (VIRIDIS[i + 1][k] - x));
}

// The upper JODs take more room: that is where approximations are judged.
const place = (jod) => 600 * (1 - ((10 - jod) / 10) ** 0.6);

/** The scale from 0 to 10 with the interval, the JOD and, as a ring, the JOD of rendered pictures if there is one. */
export function drawScale(host, score) {
    const picture = svg("svg", {viewBox: "0 0 600 62"});
    const zones = [[0, 6], [6, 8], [8, 9], [9, 9.5], [9.5, 10]]; // of the verdicts
    const shades = ["0.10", "0.16", "0.24", "0.34", "0.48"];
    zones.forEach(([low, high], i) =>
        picture.append(svg("rect", {x: place(low) + 1, y: 20, width: place(high) - place(low) - 2, height: 12, rx: 3, fill: "var(--accent)", opacity: shades[i]})));
    for (const jod of [0, 6, 8, 9, 9.5, 10]) picture.append(svg("text", {x: place(jod), y: 54, "text-anchor": jod === 0 ? "start" : jod === 10 ? "end" : "middle"}, String(jod)));
    if (score) {
        if (score.low !== null) picture.append(svg("rect", {x: place(score.low), y: 17, width: Math.max(place(score.high) - place(score.low), 2), height: 18, rx: 4, fill: "var(--test)", opacity: 0.35}));
        picture.append(svg("rect", {x: place(score.jod) - 2, y: 10, width: 4, height: 32, rx: 2, fill: "var(--test)"}));
        if (score.rendered !== undefined) picture.append(svg("circle", {cx: place(score.rendered), cy: 26, r: 7, fill: "none", stroke: "var(--ref)", "stroke-width": 2}));
    }
    host.replaceChildren(picture);
}

const luminance = (values, at) => 0.2126 * values[at] + 0.7152 * values[at + 1] + 0.0722 * values[at + 2];

/** Four charts of the luminance of f_r of both, logarithmic. */
export function drawSlices(host, [ref, test]) {
    const N = 181, W = 260, H = 180, LEFT = 34, BOTTOM = 26, TOP = 22;
    const titles = ["Around the mirror, θd = 0°", "Light at 10°", "Light at 45°", "Light at 75°"];
    host.replaceChildren(...titles.map((title, k) => {
        const series = [ref, test].map((f) => Float64Array.from({length: N}, (_, i) => luminance(f, 3 * (k * N + i))));
        const values = series.flatMap((s) => [...s]).filter((x) => x > 0).sort((a, b) => a - b);
        const high = Math.ceil(Math.log10(values[values.length - 1] ?? 1) + 0.05), low = Math.max(Math.floor(Math.log10(values[Math.floor(values.length / 50)] ?? 0.1)), high - 7);
        const x = (i) => LEFT + ((W - LEFT - 12) * i) / (N - 1), y = (value) => TOP + ((H - TOP - BOTTOM) * (high - Math.log10(value))) / (high - low);
        const picture = svg("svg", {viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": `${title}: luminance of both BRDFs`});
        picture.append(svg("text", {x: LEFT, y: 13, "font-weight": 600}, title));
        for (let p = low; p <= high; p += Math.ceil((high - low) / 4)) {
            picture.append(svg("path", {class: "axis", d: `M${LEFT} ${y(10 ** p)}H${W - 12}`}));
            picture.append(svg("text", {x: LEFT - 5, y: y(10 ** p) + 4, "text-anchor": "end"}, p < -2 || p > 3 ? `1e${p}` : String(10 ** p)));
        }
        for (const tick of k ? [0, 30, 60, 90, 120, 150, 180] : [0, 5, 20, 45, 90])
            picture.append(svg("text", {x: k ? x(tick) : LEFT + (W - LEFT - 12) * Math.sqrt(tick / 90), y: H - 9, "text-anchor": "middle"}, `${k ? tick - 90 : tick}°`));
        series.forEach((s, member) => {
            let d = "", pen = "M";
            s.forEach((value, i) => {
                if (!(value > 0)) return void (pen = "M");
                d += `${pen}${x(i).toFixed(1)} ${Math.min(y(value), H - BOTTOM).toFixed(1)}`;
                pen = "L";
            });
            picture.append(svg("path", {class: member ? "test" : "ref", d}));
        });
        return picture;
    }));
}

/** The map (60, 90) of differences over theta_h and theta_d, from 0 to its 99th percentile. */
export function drawMap(host, map) {
    const finite = [...map].filter(Number.isFinite).sort((a, b) => a - b), end = Math.max(finite[Math.floor(finite.length * 0.99)] ?? 0, 0.01);
    const image = new ImageData(90, 60);
    map.forEach((value, i) => {
        const at = 4 * ((59 - Math.floor(i / 90)) * 90 + (i % 90));
        image.data.set(Number.isFinite(value) ? [...viridis(value / end), 255] : [0, 0, 0, 0], at);
    });
    const canvas = make("canvas", {width: 90, height: 60, role: "img", "aria-label": "Mean difference of log f over theta h and theta d"});
    canvas.getContext("2d").putImageData(image, 0, 0);
    const up = [90, 60, 30, 0].map((deg) => make("i", {}, `${deg}°`)), along = [0, 5, 20, 45, 90].map((deg) => make("i", {style: `left:${100 * Math.sqrt(deg / 90)}%`}, `${deg}°`));
    host.replaceChildren(make("div", {class: "plot"}, make("span", {class: "up", "aria-hidden": "true"}, ...up), canvas, make("span", {class: "along", "aria-hidden": "true"}, ...along)),
        make("p", {class: "note"}, `θh to the right (0° is the mirror direction), θd upwards. Brightest: |Δ log fr| of ${end.toPrecision(2)}.`));
}

/** Rows of name, bar and value; values from -range to range, or from 0 on. */
export function drawParts(host, score) {
    const shift = score.shift ?? [null, null, null];
    const rows = [["darker – brighter", shift[0], 20, true], ["yellower – bluer", shift[1], 20, true], ["greener – redder", shift[2], 20, true],
        ["flatter – more contrast", score.contrast, 0.5, true], ["highlights and shading", score.structure, 40, false]];
    host.replaceChildren(...rows.flatMap(([name, value, range, signed]) => {
        const part = Math.min(Math.abs(value ?? 0) / range, 1) * (signed ? 50 : 100);
        const left = signed ? (value < 0 ? 50 - part : 50) : 0;
        const bar = make("span", {class: "bar"}, make("i", {style: `left:${left}%;width:${Math.max(part, 0.8)}%`}));
        return [make("dt", {}, name), bar, make("dd", {}, value === null ? "–" : value.toFixed(2))];
    }), make("dt", {}, "seen apart"), make("span"), make("dd", {}, score.apart?.[0] == null ? "–" : `${score.apart[0].toFixed(2)} JOD`));
}

/** The charts of a report, from the data in it. */
export function drawReport() {
    JSON.parse(document.getElementById("nqm-charts").textContent).forEach(({score, slices, map}, i) => {
        const host = (name) => document.getElementById(`${name}-${i + 1}`);
        drawScale(host("jod"), score);
        if (!slices) return;
        drawSlices(host("slices"), slices);
        drawMap(host("map"), map);
    });
}
