// Opens a page of this folder in Chromium and prints what it found, as JSON.
//
// usage: node chromium.mjs PACKAGE NODE_MODULES FOLDER CHROMIUM PAGE [csp:POLICY] [CHROMIUM_FLAG...]
// With csp:POLICY pages have that Content-Security-Policy.
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { launch, serve } from './browser.mjs';

const [packageFolder, modules, files, executable, name, ...more] = process.argv.slice(2);
const [policy, flags] = more[0]?.startsWith('csp:') ? [more[0].slice(4), more.slice(1)] : [undefined, more];
const pages = path.dirname(fileURLToPath(import.meta.url));
const roots = { package: packageFolder, modules, files, pages, examples: path.join(pages, '../../../docs/examples') };
const server = await serve(roots, policy ? { 'Content-Security-Policy': policy } : {});
const browser = await launch(modules, executable, flags);
const page = await browser.newPage({ viewport: { width: 300, height: 300 } });
page.on('pageerror', (error) => console.error(error.message));
page.on('console', (message) => message.text().startsWith('FOUND ') || console.error(message.text()));
const found = page.waitForEvent('console', { predicate: (m) => m.text().startsWith('FOUND '), timeout: 150000 });
await page.goto(`${server.address}/pages/${name}`);
const text = (await found).text().slice(6);
await browser.close();
server.close();
console.log(text);
