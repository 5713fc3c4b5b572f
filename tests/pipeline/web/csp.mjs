// What a page with a Content-Security-Policy can do: an asset here and in a worker, or the reason why not.
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
