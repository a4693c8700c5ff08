// SPDX-License-Identifier: MIT
// browser.mjs - drives a headless Chromium by the DevTools protocol over a pipe, without packages and without network.
import {spawn} from "node:child_process";
import {mkdtempSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";

const OPTIONS = ["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--disable-dev-shm-usage", "--host-resolver-rules=MAP * ~NOTFOUND", "--proxy-server=127.0.0.1:9", "--use-gl=angle",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars", "--remote-debugging-pipe"];

/** {open(url, width, height, dark), evaluate(expression), until(expression, seconds), shot(), close(), console: messages}. */
export async function startBrowser(path) {
    const profile = mkdtempSync(join(tmpdir(), "nqm-browser-"));
    const child = spawn(path, [...OPTIONS, `--user-data-dir=${profile}`], {stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"]});
    const waiting = new Map(), messages = [];
    let next = 1, session, buffer = "";
    child.stdio[4].setEncoding("utf8");
    child.stdio[4].on("data", (text) => {
        buffer += text;
        for (let end; (end = buffer.indexOf("\0")) >= 0; buffer = buffer.slice(end + 1)) {
            const {id, result, error, method, params} = JSON.parse(buffer.slice(0, end));
            if (id) {
                const {resolve, reject} = waiting.get(id);
                waiting.delete(id);
                if (error) reject(new Error(error.message));
                else resolve(result);
            } else if (method === "Log.entryAdded") messages.push(params.entry.text);
            else if (method === "Runtime.consoleAPICalled") messages.push(params.args.map((x) => x.value ?? x.description).join(" "));
            else if (method === "Runtime.exceptionThrown") messages.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
        }
    });
    child.on("exit", () => waiting.forEach(({reject}) => reject(new Error("the browser ended"))));
    const send = (method, params = {}, target = session) => new Promise((resolve, reject) => {
        waiting.set(next, {resolve, reject});
        child.stdio[3].write(JSON.stringify({id: next++, method, params, ...(target ? {sessionId: target} : {})}) + "\0");
    });
    const {targetId} = await send("Target.createTarget", {url: "about:blank"}, null);
    session = (await send("Target.attachToTarget", {targetId, flatten: true}, null)).sessionId;
    await Promise.all(["Page", "Runtime", "Log"].map((domain) => send(`${domain}.enable`)));
    const browser = {
        console: messages, send,
        async open(url, width = 1280, height = 900, dark = false) {
            await send("Emulation.setDeviceMetricsOverride", {width, height, deviceScaleFactor: 1, mobile: width < 600});
            await send("Emulation.setEmulatedMedia", {features: [{name: "prefers-color-scheme", value: dark ? "dark" : "light"}]});
            await send("Page.navigate", {url: "about:blank"});
            await browser.until("location.href === 'about:blank'");
            await send("Page.navigate", {url});
            await browser.until("location.href !== 'about:blank' && document.readyState === 'complete'");
        },
        async evaluate(expression) {
            const {result, exceptionDetails} = await send("Runtime.evaluate", {expression, awaitPromise: true, returnByValue: true, userGesture: true});
            if (exceptionDetails) throw new Error(`${expression}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}`);
            return result.value;
        },
        /** Wait until an expression is true. */
        async until(expression, seconds = 1800) {
            const end = Date.now() + 1000 * seconds;
            for (;;) {
                const value = await browser.evaluate(expression).catch((error) => (/context|navigated/.test(error.message) ? false : Promise.reject(error)));
                if (value) return value;
                if (Date.now() > end) throw new Error(`not within ${seconds} s: ${expression}; ${await browser.evaluate("document.getElementById('fault')?.textContent")}`);
                await new Promise((resolve) => setTimeout(resolve, 30));
            }
        },
        async key(key, text) {
            await send("Input.dispatchKeyEvent", {type: "keyDown", key, ...(text ? {text} : {}), windowsVirtualKeyCode: {Enter: 13, ArrowDown: 40, Tab: 9, Escape: 27}[key] ?? 0});
            await send("Input.dispatchKeyEvent", {type: "keyUp", key});
        },
        async shot(whole = true) {
            const {cssContentSize: size} = await send("Page.getLayoutMetrics");
            const {data} = await send("Page.captureScreenshot", {format: "png", captureBeyondViewport: true,
                ...(whole ? {clip: {x: 0, y: 0, width: size.width, height: size.height, scale: 1}} : {})});
            return Buffer.from(data, "base64");
        },
        async close() {
            child.removeAllListeners("exit");
            const gone = new Promise((resolve) => child.on("exit", resolve));
            send("Browser.close", {}, null).catch(() => child.kill());
            await gone;
            try {
                rmSync(profile, {recursive: true, force: true, maxRetries: 20, retryDelay: 100});
            } catch {
                // a process of the browser is still writing: the folder is in /tmp
            }
        },
    };
    return browser;
}
