// Helpers for scripts that look at pages: a server on loopback, and Chromium with GL in software.
import fs from 'node:fs';
import http from 'node:http';
import { createRequire } from 'node:module';
import path from 'node:path';

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css' };

/** Serves folders under their names; `headers` go with every page. Answers the address, and what closes it. */
export async function serve(roots, headers = {}) {
    const server = http.createServer((request, response) => {
        const [, root, ...rest] = decodeURIComponent(new URL(request.url, 'http://x').pathname).split('/');
        const file = roots[root] && path.join(roots[root], ...rest);
        if (!file || !file.startsWith(roots[root]) || !fs.existsSync(file)) return void response.writeHead(404).end();
        const type = TYPES[path.extname(file)] ?? 'application/octet-stream';
        response.writeHead(200, { 'Content-Type': type, ...(type === 'text/html' ? headers : {}) });
        response.end(fs.readFileSync(file));
    });
    await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
    return { address: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

export async function launch(modules, executablePath, more = []) {
    const { chromium } = createRequire(path.join(path.resolve(modules), '/'))('playwright-core');
    const args = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', ...more];
    return chromium.launch({ executablePath, args });
}
