// usage: node runtime/web/build.mjs PENUMBRA.wasm NODE_MODULES OUT
// Makes the npm package in the folder OUT: the sources by tsc, and the module inside a string and beside it.
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import zlib from 'node:zlib';

const here = path.dirname(fileURLToPath(import.meta.url));
const [wasm, modules, out] = process.argv.slice(2);
if (!out) {
    console.error('usage: node build.mjs PENUMBRA.wasm NODE_MODULES OUT');
    process.exit(1);
}
const dist = path.join(out, 'dist');
fs.rmSync(dist, { recursive: true, force: true });
fs.mkdirSync(dist, { recursive: true });
// tsc finds the types of three.js beside the output alone.
const link = path.join(out, 'node_modules');
fs.rmSync(link, { recursive: true, force: true });
fs.symlinkSync(path.resolve(modules), link);
fs.cpSync(path.join(here, 'src'), path.join(out, 'src'), { recursive: true });
fs.copyFileSync(path.join(here, 'tsconfig.json'), path.join(out, 'tsconfig.json'));
for (const name of ['package.json', 'README.md']) fs.copyFileSync(path.join(here, name), path.join(out, name));
fs.copyFileSync(path.join(here, '../../LICENSE'), path.join(out, 'LICENSE'));
execFileSync(process.execPath, [path.join(link, 'typescript/bin/tsc'), '-p', out, '--outDir', dist], { stdio: 'inherit' });
const bytes = fs.readFileSync(wasm);
fs.writeFileSync(path.join(dist, 'penumbra.wasm'), bytes);
fs.writeFileSync(
    path.join(dist, 'packed.js'),
    `export const packed = '${zlib.gzipSync(bytes, { level: 9 }).toString('base64')}';\n`,
);
fs.copyFileSync(path.join(out, 'src/packed.d.ts'), path.join(dist, 'packed.d.ts'));
