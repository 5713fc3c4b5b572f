// Opens the demo page in Chromium, from a server and from disk, uses its panel, and prints what it found, as JSON.
//
// usage: node demo.mjs FOLDER NODE_MODULES CHROMIUM      FOLDER has site and penumbra.html
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { launch, serve } from './browser.mjs';

const [folder, modules, executable] = process.argv.slice(2);
const server = await serve({ site: path.join(folder, 'site') });
const browser = await launch(modules, executable);
const errors = [];

async function open(address, state) {
    const page = await browser.newPage({ viewport: { width: 420, height: 640 }, hasTouch: true });
    page.on('pageerror', (error) => errors.push(error.message));
    page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
    await page.goto(`${address}#${new URLSearchParams({ paused: 'true', ...state })}`);
    await page.waitForFunction(() => globalThis.penumbraDemo !== undefined, undefined, { timeout: 100000 });
    await page.evaluate(() => globalThis.penumbraDemo.stage.renderer.setAnimationLoop(null));
    return page;
}

/** Draws one moment, and answers the pixels. */
const pixels = (page) =>
    page.evaluate(() => {
        const demo = globalThis.penumbraDemo;
        demo.actor.pose('Walk', 0.2);
        for (let i = 0; i < 2; ++i) demo.draw(); // the ground has new shadows in every second frame
        const gl = demo.stage.renderer.getContext();
        const out = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
        gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, out);
        return Array.from(out);
    });
const apart = (a, b) => a.reduce((sum, value, i) => sum + Math.abs(value - b[i]), 0) / a.length;
/** Presses what has a name and a value in the panel, and waits for what it does. */
async function press(page, name, value) {
    await page.tap(`[name=${name}]${value ? `[value=${value}]` : ''}`);
    await page.waitForTimeout(100);
}

const page = await open(`${server.address}/site/index.html`, {});
const colour = await pixels(page);
const found = {};
await press(page, 'compare');
await page.evaluate(() => {
    globalThis.penumbraDemo.split = 0; // the truth in the whole window
});
found.truth = apart(colour, await pixels(page));
await page.focus('#divider');
await page.keyboard.press('ArrowRight');
found.divider = await page.getAttribute('#divider', 'aria-valuenow');
await press(page, 'clip', 'Run');
found.comparesOnlyWalk = !(await page.isChecked('[name=compare]')) && (await page.isHidden('#divider'));
for (const shadow of ['occlusion', 'off']) {
    await press(page, 'shadow', shadow);
    found[shadow] = apart(colour, await pixels(page));
}
await press(page, 'sun');
found.sun = apart(colour, await pixels(page));
found.address = await page.evaluate(() => location.hash);
found.stats = /^\d+\.\d ms · \d+ Hz$/.test(await page.textContent('#stats')) || (await page.textContent('#stats')) === '';
const disk = await open(pathToFileURL(path.resolve(folder, 'penumbra.html')).href, {});
found.fromDisk = apart(colour, await pixels(disk));
await browser.close();
server.close();
console.log(JSON.stringify({ ...found, errors }));
