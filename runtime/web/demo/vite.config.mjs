// How Vite builds the demo page. All that lies elsewhere comes by the environment, as build.mjs says it:
//   PENUMBRA_PACKAGE  the npm package          PENUMBRA_DATA     files that the page loads
//   PENUMBRA_MODULES  node_modules             PENUMBRA_SINGLE   1: all in one HTML file
import fs from 'node:fs';
import path from 'node:path';

const { PENUMBRA_PACKAGE: pkg, PENUMBRA_MODULES: modules, PENUMBRA_DATA: data, PENUMBRA_SINGLE: single } = process.env;
const ID = 'virtual:penumbra-data';

/** Where each file of the data is: beside the page, or inside of it. */
function dataFiles() {
    const url = (name) =>
        single ? `data:application/octet-stream;base64,${fs.readFileSync(path.join(data, name)).toString('base64')}` : `./${name}`;
    const urls = () => Object.fromEntries(fs.readdirSync(data).map((name) => [name, url(name)]));
    return {
        name: 'penumbra-data',
        resolveId: (id) => (id === ID ? `\0${ID}` : undefined),
        load: (id) => (id === `\0${ID}` ? `export default ${JSON.stringify(urls())};` : undefined),
    };
}

/** Puts the script and the style into the page. Files from disk may not import modules, and inline ones need none. */
function inlined() {
    return {
        name: 'penumbra-inlined',
        enforce: 'post',
        generateBundle(_, bundle) {
            const page = bundle['index.html'];
            for (const [name, part] of Object.entries(bundle)) {
                if (part === page) continue;
                const script = part.type === 'chunk';
                const text = script ? part.code.replace(/<\/script/g, '<\\/script') : part.source;
                const tag = script
                    ? new RegExp(`<script[^>]*src="[^"]*${name}"[^>]*></script>`)
                    : new RegExp(`<link[^>]*href="[^"]*${name}"[^>]*>`);
                page.source = page.source.replace(tag, () => (script ? `<script type="module">${text}</script>` : `<style>${text}</style>`));
                delete bundle[name];
            }
        },
    };
}

export default {
    root: import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname),
    base: './',
    publicDir: single ? false : data,
    resolve: {
        alias: [
            { find: /^penumbra-player$/, replacement: path.join(pkg, 'dist/index.js') },
            { find: /^penumbra-player\/three$/, replacement: path.join(pkg, 'dist/three/index.js') },
            { find: /^penumbra-player\/sh$/, replacement: path.join(pkg, 'dist/sh.js') },
            { find: /^three\/addons\//, replacement: path.join(modules, 'three/examples/jsm/') },
            { find: /^three$/, replacement: path.join(modules, 'three/build/three.module.js') },
        ],
    },
    build: { target: 'es2022', emptyOutDir: true, chunkSizeWarningLimit: 20000, modulePreload: false, reportCompressedSize: false },
    plugins: [dataFiles(), ...(single ? [inlined()] : [])],
    logLevel: 'warn',
};
