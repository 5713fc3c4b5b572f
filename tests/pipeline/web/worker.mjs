// Characters that a module worker evaluates: what the test of Chromium looks at. Says its findings as JSON.
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { clone } from 'three/addons/utils/SkeletonUtils.js';
import { Character, load } from 'penumbra-player';
import { PenumbraCharacter, PenumbraEnvironment, PenumbraLoader, assetOf } from 'penumbra-player/three';
import { Crowd, PenumbraWorker, startWorker } from 'penumbra-player/worker';
import { Loss } from '/package/dist/loss.js';

const found = { compared: 0, different: 0 };
const LIGHT = Float32Array.from({ length: 75 }, (_, i) => (i < 3 ? 3 : Math.sin(1.7 * i)));

const bytesOf = async (name) => (await fetch(`/files/${name}`)).arrayBuffer();
const codeOf = (promise) => promise.then(() => 'accepted', (error) => error.code);

/** Numbers whose bits are not the same. */
function differing(a, b) {
    const [x, y] = [a, b].map((values) => new Uint32Array(values.buffer, values.byteOffset, values.length));
    if (x.length !== y.length || x.length === 0) return Infinity;
    return x.reduce((sum, bits, i) => sum + (bits !== y[i]), 0);
}

/** Matrices that turn each joint a little about an axis of its own. */
function bent(k, count) {
    const matrices = new Float32Array(16 * count);
    for (let j = 0; j < count; ++j) {
        const angle = 0.1 * Math.sin(k + j);
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        matrices.set([c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], 16 * j);
    }
    return matrices;
}

/** Poses, qualities and lights in the worker and here. */
async function compare(runtime, worker, name) {
    const bytes = await bytesOf(name);
    const asset = runtime.open(bytes);
    const there = await worker.open(bytes);
    const character = new Character(asset);
    const remote = await there.create();
    const losses = new Loss();
    const here = new Float32Array(4 * asset.vertexCount);
    const joints = asset.jointNames.length;
    for (let k = 0; k < 6; ++k) {
        const light = [{}, { sh: LIGHT }, { sh: LIGHT, order: 3, strength: 0.5 }][k % 3];
        const quality = k < 3 ? 'full' : 'fast';
        character.setQuality(quality);
        character.setPose(bent(k, joints));
        character.evaluate();
        losses.compute(character, light, here);
        const loss = await remote.update((matrices) => matrices.set(bent(k, joints)), [], { ...light, quality });
        found.compared += here.length;
        found.different += differing(here, loss);
    }
    found.refused = [await codeOf(worker.open(new Uint8Array(9)))];
    remote.dispose();
    remote.dispose();
    there.dispose();
    found.refused.push(await codeOf(remote.update(() => undefined, [])));
    character.dispose();
    asset.dispose();
}

/** The same in three.js, and 50 clones of one file that a crowd updates. */
async function inThree(runtime, worker) {
    const loader = new GLTFLoader().register((parser) => new PenumbraLoader(parser, runtime));
    const gltf = await loader.loadAsync('/files/character.glb');
    const asset = assetOf(gltf);
    const there = await worker.open(await bytesOf('composed.pnb'));
    const environment = new PenumbraEnvironment(LIGHT);
    const lossOf = async (options) => {
        const root = clone(gltf.scene);
        const character = new PenumbraCharacter(asset, root, { environment, ...options });
        await character.update();
        const values = [];
        root.traverse((mesh) => mesh.isMesh && values.push(...mesh.geometry.attributes.penumbraLoss.array));
        character.dispose();
        return Float32Array.from(values);
    };
    found.inThree = { compared: 0, different: 0 };
    for (const quality of ['full', 'fast']) {
        const [here, far] = [await lossOf({ quality }), await lossOf({ quality, worker: await there.create() })];
        found.inThree.compared += here.length;
        found.inThree.different += differing(here, far);
    }
    const busy = new PenumbraCharacter(asset, clone(gltf.scene), { worker: await there.create() });
    const first = busy.update();
    found.oneUnderWay = busy.update() === first;
    busy.dispose();
    await first; // work under way still ends without an error
    found.refused.push(await codeOf(busy.update()));

    const crowd = new Crowd();
    const counts = new Map();
    const errors = [];
    crowd.onerror = (error) => errors.push(String(error));
    for (let i = 0; i < 50; ++i) {
        const character = new PenumbraCharacter(asset, clone(gltf.scene), { environment, worker: await there.create() });
        const member = character.member(() => i);
        counts.set(i, 0);
        crowd.add({ ...member, apply: (loss) => (member.apply(loss), counts.set(i, counts.get(i) + 1)) });
    }
    const start = performance.now();
    while (performance.now() - start < 5000 && (Math.min(...counts.values()) < 1 || crowd.updates <= 60)) {
        crowd.update();
        await new Promise(requestAnimationFrame);
    }
    found.crowd = { updates: crowd.updates, least: Math.min(...counts.values()), errors: [...errors] };
}

async function main() {
    const runtime = await load();
    const worker = new PenumbraWorker(startWorker());
    await compare(runtime, worker, 'additive.pnb');
    await compare(runtime, worker, 'composed.pnb');
    await inThree(runtime, worker);
    worker.dispose();
    worker.dispose();
    found.refused.push(await codeOf(worker.open(new Uint8Array(9))));
}

main()
    .catch((error) => (found.error = `${error.code ?? ''} ${error.stack}`))
    .finally(() => console.log('FOUND ' + JSON.stringify(found)));
