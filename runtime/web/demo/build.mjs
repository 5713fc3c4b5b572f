// usage: node runtime/web/demo/build.mjs PACKAGE NODE_MODULES DATA OUT
// Builds the demo page into OUT/site, which any server of files can serve, and as OUT/penumbra.html, which opens from
// disk. DATA has what the page loads: scripts/demo --web makes it.
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const [pkg, modules, data, out] = process.argv.slice(2).map((name) => path.resolve(name));
if (!out) {
    console.error('usage: node build.mjs PACKAGE NODE_MODULES DATA OUT');
    process.exit(1);
}
const config = path.join(path.dirname(fileURLToPath(import.meta.url)), 'vite.config.mjs');

function build(folder, single) {
    const env = { ...process.env, PENUMBRA_PACKAGE: pkg, PENUMBRA_MODULES: modules, PENUMBRA_DATA: data, PENUMBRA_SINGLE: single };
    const vite = path.join(modules, 'vite/bin/vite.js');
    execFileSync(process.execPath, [vite, 'build', '--config', config, '--outDir', folder], { env, stdio: 'inherit' });
}

build(path.join(out, 'site'), '');
const scratch = path.join(out, 'single');
build(scratch, '1');
fs.renameSync(path.join(scratch, 'index.html'), path.join(out, 'penumbra.html'));
fs.rmSync(scratch, { recursive: true });
