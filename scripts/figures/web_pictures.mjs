// Pictures of the demo page in Chromium with software GL: on a desktop and on a phone.
//
// usage: node scripts/figures/web_pictures.mjs PAGE NODE_MODULES OUT [--file]
// PAGE is the folder of the site, which is served on loopback; with --file it is one HTML file that is opened from disk.
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { launch, serve } from '../../tests/pipeline/web/browser.mjs';

const [site, modules, out, mode] = process.argv.slice(2);
const server = await serve({ site });
const address = mode === '--file' ? pathToFileURL(path.resolve(site)).href : `${server.address}/site/index.html`;
const browser = await launch(modules, '/usr/bin/chromium');

async function open(state, options) {
    const context = await browser.newContext(options);
    const page = await context.newPage();
    page.on('pageerror', (error) => console.error(error.message));
    page.on('console', (text) => text.type() === 'error' && console.error(text.text()));
    await page.goto(`${address}#${new URLSearchParams(state)}`);
    await page.waitForFunction(() => globalThis.penumbraDemo !== undefined, undefined, { timeout: 180000 });
    return page;
}

/** A moment of the walk, drawn twice so that the shadows of the ground are its own. */
const still = (page, seconds) =>
    page.evaluate((time) => {
        const demo = globalThis.penumbraDemo;
        demo.stage.renderer.setAnimationLoop(null);
        demo.actor.pose('Walk', time);
        for (let i = 0; i < 2; ++i) demo.draw();
    }, seconds);

const desktop = { viewport: { width: 1120, height: 700 } };
const phone = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true };
for (const [name, options, state] of [
    ['desktop', desktop, { paused: 'true' }],
    ['desktop_off', desktop, { paused: 'true', shadow: 'off' }],
    ['desktop_compare', desktop, { paused: 'true', compare: 'true' }],
    ['desktop_sun', desktop, { paused: 'true', sun: 'true', turn: '60', sky: 'Indoors' }],
    ['phone', phone, { paused: 'true' }],
    ['phone_compare', phone, { paused: 'true', compare: 'true' }],
]) {
    const page = await open(state, options);
    await still(page, 2 / 3);
    await page.screenshot({ path: path.join(out, `${name}.png`), scale: 'css' });
    await page.context().close();
    console.log(name);
}
await browser.close();
server.close();
