// Tries to load an asset under a Content-Security-Policy, here and in a worker, and reports the reason if it fails.
import { Character, load } from '/package/dist/index.js';
import { PenumbraWorker, startWorker } from '/package/dist/worker/index.js';

const found = { code: '' };

async function main() {
    const runtime = await load();
    const bytes = await (await fetch('/files/additive.pnb')).arrayBuffer();
    const character = new Character(runtime.open(bytes));
    character.evaluate();
    found.vertices = character.ambient().length;
    const there = await new PenumbraWorker(startWorker()).open(bytes);
    found.worker = there.vertexCount;
}

main()
    .catch((error) => Object.assign(found, { code: error.code ?? 'none', message: error.message }))
    .finally(() => console.log('FOUND ' + JSON.stringify(found)));
