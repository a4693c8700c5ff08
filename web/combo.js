// SPDX-License-Identifier: MIT
//
// A text field with a list of completions, by keys and mouse.
import {make} from "./charts.js";

/** input: a combobox with the listbox list. complete(text): [{text, about}]; isWhole(text): whether to take it while it is typed. */
export function setUpCombo(input, list, {complete, isWhole, take: takeText}) {
    let options = [], at = -1, timer;
    function close() {
        list.hidden = true;
        input.setAttribute("aria-expanded", "false");
        input.removeAttribute("aria-activedescendant");
        at = -1;
    }
    function mark(next) {
        at = next;
        [...list.children].forEach((li, i) => li.setAttribute("aria-selected", String(i === at)));
        if (at < 0) return input.removeAttribute("aria-activedescendant");
        input.setAttribute("aria-activedescendant", list.children[at].id);
        list.children[at].scrollIntoView({block: "nearest"});
    }
    function take(i) {
        input.value = options[i].text;
        if (/[:=]$/.test(input.value)) return open();
        close();
        takeText(input.value);
    }
    function open() {
        options = complete(input.value);
        list.replaceChildren(...options.map(({text, about}, i) => make("li", {id: `${list.id}-${i}`, role: "option", "aria-selected": "false",
            onmousedown: (event) => (event.preventDefault(), take(i))}, make("span", {}, text), make("small", {}, about))));
        list.hidden = !options.length;
        input.setAttribute("aria-expanded", String(!list.hidden));
        at = -1;
    }
    input.addEventListener("input", () => {
        open();
        clearTimeout(timer);
        timer = setTimeout(() => isWhole(input.value) && takeText(input.value), 200);
    });
    input.addEventListener("focus", () => input.select());
    input.addEventListener("blur", close);
    input.addEventListener("change", () => takeText(input.value));
    input.addEventListener("keydown", (event) => {
        if (event.key === "ArrowDown" || event.key === "ArrowUp") {
            if (list.hidden) open();
            const n = options.length;
            if (n) mark(event.key === "ArrowDown" ? (at + 1) % n : (at + n - (at < 0 ? 0 : 1)) % n);
            event.preventDefault();
        } else if (event.key === "Enter") {
            if (at >= 0) take(at);
            else {
                close();
                takeText(input.value.trim());
            }
        } else if (event.key === "Escape") close();
    });
}
