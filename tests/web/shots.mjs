// SPDX-License-Identifier: MIT
// shots.mjs PAGE CHROMIUM FOLDER - the pictures of doc/web.md: a wide window, and a narrow one in the dark.
import {writeFileSync} from "node:fs";
import {join, resolve} from "node:path";
import {pathToFileURL} from "node:url";
import {startBrowser} from "./browser.mjs";

const [, , page, chromium, folder] = process.argv, browser = await startBrowser(chromium);
for (const [name, width, height, dark, scale] of [["web", 1240, 790, false, 0.8], ["web-narrow", 390, 1330, true, 0.6]]) {
    await browser.open(pathToFileURL(resolve(page)).href, width, height, dark);
    await browser.until("document.body.dataset.pictures", 200);
    const {data} = await browser.send("Page.captureScreenshot", {format: "png", clip: {x: 0, y: 0, width, height, scale}});
    writeFileSync(join(folder, `${name}.png`), Buffer.from(data, "base64"));
}
await browser.close();
