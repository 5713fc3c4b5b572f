// A character with soft shadows on WebGPURenderer, beside WebGLRenderer: what the test of Chromium looks at.
// With ?backend=webgl the renderer takes its other back end.
import * as THREE from 'three';
import { WebGPURenderer } from 'three/webgpu';
import { clone } from 'three/addons/utils/SkeletonUtils.js';
import { Character, load } from 'penumbra-player';
import * as forWebGL from 'penumbra-player/three';
import * as forNodes from 'penumbra-player/three/webgpu';
import { SIZE, apart, pixelsOf, stage } from './scene.mjs';

const found = {};
const forceWebGL = new URLSearchParams(location.search).get('backend') === 'webgl';

/** Pictures without shadows, with those of the character, with those of the ground, turned, and without again. */
async function pictures(runtime, { PenumbraCharacter, PenumbraGround }, shot) {
    const here = await stage(runtime);
    const { scene, root, floor, environment, asset } = here;
    scene.environment = here.texture;
    const out = { before: await shot(here) };
    const character = new PenumbraCharacter(asset, root, { environment });
    character.update();
    out.character = await shot(here);
    const ground = new PenumbraGround(runtime, floor, [character], { environment, every: 1 });
    ground.update();
    out.ground = await shot(here);
    environment.setRotation(new THREE.Matrix4().makeRotationY(2));
    scene.environmentRotation.set(0, 2, 0);
    character.update();
    ground.update();
    out.turned = await shot(here);
    scene.environmentRotation.set(0, 0, 0);
    environment.setRotation(new THREE.Matrix4());
    // Others that share the materials must not count twice, in whatever order they come and go.
    const copy = clone(root);
    copy.visible = false;
    scene.add(copy);
    const twin = new PenumbraCharacter(asset, copy, { environment });
    const far = new PenumbraGround(runtime, floor, [character], { environment, every: 1, radius: 1e-3 });
    for (const one of [character, twin, far, ground]) one.update();
    out.twice = await shot(here);
    character.dispose();
    [root.visible, copy.visible] = [false, true];
    out.second = await shot(here);
    [root.visible, copy.visible] = [true, false];
    for (const one of [ground, twin, far, character, ground]) one.dispose();
    out.after = await shot(here);
    asset.dispose();
    return out;
}

async function read(device, buffer) {
    const copy = device.createBuffer({ size: buffer.size, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ });
    const encoder = device.createCommandEncoder();
    encoder.copyBufferToBuffer(buffer, 0, copy, 0, buffer.size);
    device.queue.submit([encoder.finish()]);
    await copy.mapAsync(GPUMapMode.READ);
    return new Float32Array(copy.getMappedRange().slice(0));
}

/** The largest difference, which NaN and other sizes do not pass. */
function difference(a, b) {
    if (a.length !== b.length || a.length === 0) return Infinity;
    return a.reduce((most, value, i) => (Math.abs(value - b[i]) <= most ? most : Math.abs(value - b[i])), 0);
}

/** A model by WGSL, beside the core: each `step`th frame. */
async function compute(runtime, device, name, step) {
    const asset = runtime.open(await (await fetch(`/files/${name}`)).arrayBuffer());
    device.pushErrorScope('validation');
    const begin = performance.now();
    const evaluator = new forNodes.GpuEvaluator(device, asset);
    const character = new Character(asset);
    const worst = { frames: 0, coefficients: 0, ambient: 0, square: 0, least: 1 };
    for (let frame = 0; frame < asset.frameCount; frame += step) {
        character.setFrame(frame);
        evaluator.evaluate(character);
        const there = [await read(device, evaluator.coefficients), await read(device, evaluator.ambient)];
        character.evaluate();
        const ambient = character.ambient();
        worst.ambient = Math.max(worst.ambient, difference(there[1], ambient));
        worst.coefficients = Math.max(worst.coefficients, difference(there[0], character.coefficients));
        worst.square += there[1].reduce((sum, e, i) => sum + (e - ambient[i]) ** 2, 0) / ambient.length;
        worst.least = Math.min(worst.least, ...there[1]);
        ++worst.frames;
    }
    evaluator.dispose();
    evaluator.dispose();
    worst.seconds = (performance.now() - begin) / 1000;
    worst.rms = Math.sqrt(worst.square / worst.frames);
    worst.mistake = (await device.popErrorScope())?.message ?? '';
    return worst;
}

async function main() {
    const runtime = await load();
    const old = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
    old.setSize(SIZE, SIZE);
    const reference = await pictures(runtime, forWebGL, ({ scene, camera }) => {
        old.render(scene, camera);
        return pixelsOf(old.domElement);
    });
    old.dispose();
    const renderer = new WebGPURenderer({ forceWebGL });
    await renderer.init();
    found.backend = renderer.backend.isWebGPUBackend ? 'webgpu' : 'webgl';
    if (renderer.backend.isWebGPUBackend) {
        const { device } = renderer.backend;
        found.compute = { additive: await compute(runtime, device, 'additive.pnb', 1), composed: await compute(runtime, device, 'composed.pnb', 5) };
    }
    renderer.setSize(SIZE, SIZE);
    document.body.append(renderer.domElement);
    const drawn = await pictures(runtime, forNodes, async ({ scene, camera }) => {
        // The light of an environment is ready after some frames.
        for (let i = 0; i < 3; ++i) {
            renderer.render(scene, camera);
            await new Promise(requestAnimationFrame);
        }
        renderer.render(scene, camera);
        return pixelsOf(renderer.domElement);
    });
    found.onCharacter = apart(drawn.before, drawn.character);
    found.onGround = apart(drawn.character, drawn.ground);
    found.turned = apart(drawn.ground, drawn.turned);
    found.twice = Math.max(apart(drawn.ground, drawn.twice).mean, apart(drawn.ground, drawn.second).mean);
    found.after = apart(drawn.before, drawn.after);
    found.beside = Object.fromEntries(Object.keys(drawn).map((name) => [name, apart(reference[name], drawn[name]).mean]));
}

main()
    .catch((error) => (found.error = `${error.code ?? ''} ${error.stack}`))
    .finally(() => console.log('FOUND ' + JSON.stringify(found)));
