// SPDX-License-Identifier: MIT
//
// What the page says: numbers, commands, links, Markdown.

export const jod2 = (x) => (x === null || x === undefined ? "–" : x.toFixed(2));
export const interval = (s) => (s.low === null ? "" : `[${jod2(s.low)}, ${jod2(s.high)}]`);

/** A percentage of people as `nqm report` writes it. */
export function people(share) {
    const percent = 100 * share;
    return percent > 99 ? "more than 99 %" : percent < 51 ? "half" : `${percent.toFixed(0)} %`;
}

/** An argument for a POSIX shell. */
export const quote = (text) => (/^[\w@%+=:,./-]+$/.test(text) ? text : "'" + text.replaceAll("'", "'\\''") + "'");

/** The fragment of a link that opens the page with both arguments. */
export const makeHash = (ref, test) => "#" + new URLSearchParams({ref, test});
export function readHash(hash) {
    const words = new URLSearchParams(hash.replace(/^#/, ""));
    return words.has("ref") ? {ref: words.get("ref"), test: words.get("test") ?? ""} : null;
}

/** A cell of Markdown, as the tool writes it. */
const cell = (text) => String(text).replace(/[\\`*_[\]<>|~#&]/g, "\\$&").replace(/[\0-\x1f]/g, " ");

/** A table for a pull request, of rows {ref, test, score}. */
export function markdown(rows) {
    const lines = ["| JOD | 95 % | reference | approximation | how it differs |", "| ---: | --- | --- | --- | --- |"];
    for (const {ref, test, score} of rows)
        lines.push(`| ${score.error === undefined ? jod2(score.jod) : "–"} | ${score.error === undefined ? interval(score) : ""} | ${cell(ref)} | ${cell(test)} | ${cell(score.error ?? `${score.verdict}: ${score.words}`)} |`);
    return lines.join("\n") + "\n";
}

/** What may follow in a spec or preset: [{text, about}], at most n. */
export function complete(input, {presets, models}, n = 60) {
    const colon = input.indexOf(":"), model = colon > 0 && models.find(({name}) => name === input.slice(0, colon));
    const found = [];
    if (model) {
        const at = Math.max(colon, input.lastIndexOf(";")) + 1, begun = input.slice(at), used = input.slice(0, at);
        if (!begun.includes("="))
            for (const {name, n: count, low, high, required} of model.keys)
                if (name.startsWith(begun) && !used.includes(`${name}=`))
                    found.push({text: `${used}${name}=`, about: `${count === 3 ? "RGB, " : count === 2 ? "x, y, " : ""}${low} to ${high}${required ? ", needed" : ""}`});
    }
    const words = input.toLowerCase().split(/[\s:]+/).filter(Boolean);
    const matches = (name) => words.every((word) => name.includes(word));
    if (!input.includes(";") && !input.includes("=")) {
        for (const {name, keys} of models) if (!colon || (colon < 0 && matches(name))) found.push({text: `${name}:`, about: `model, ${keys.length} keys`});
        for (const name of presets) if (name !== input && matches(name.toLowerCase())) found.push({text: name, about: "measured, fitted"});
    }
    return found.slice(0, n);
}
