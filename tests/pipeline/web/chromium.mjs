// Opens a page of this folder in Chromium and prints what it found, as JSON.
//
// usage: node chromium.mjs PACKAGE NODE_MODULES FOLDER CHROMIUM PAGE
import fs from 'node:fs';
import http from 'node:http';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const [packageFolder, modules, files, executablePath, name] = process.argv.slice(2);
const { chromium } = createRequire(path.join(modules, '/'))('playwright-core');
const roots = { package: packageFolder, modules, files, pages: path.dirname(fileURLToPath(import.meta.url)) };
const types = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript' };

const server = http.createServer((request, response) => {
    const [, root, ...rest] = decodeURIComponent(new URL(request.url, 'http://x').pathname).split('/');
    const file = roots[root] && path.join(roots[root], ...rest);
    if (!file || !file.startsWith(roots[root]) || !fs.existsSync(file)) return void response.writeHead(404).end();
    response.writeHead(200, { 'Content-Type': types[path.extname(file)] ?? 'application/octet-stream' });
    response.end(fs.readFileSync(file));
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
const browser = await chromium.launch({
    executablePath,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
});
const page = await browser.newPage({ viewport: { width: 300, height: 300 } });
page.on('pageerror', (error) => console.error(error.message));
page.on('console', (message) => message.text().startsWith('FOUND ') || console.error(message.text()));
const found = page.waitForEvent('console', { predicate: (m) => m.text().startsWith('FOUND '), timeout: 150000 });
await page.goto(`http://127.0.0.1:${server.address().port}/pages/${name}`);
const text = (await found).text().slice(6);
await browser.close();
server.close();
console.log(text);
