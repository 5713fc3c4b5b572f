// A character with soft shadows on WebGPURenderer, beside WebGLRenderer: what the test of Chromium looks at.
// With ?backend=webgl the renderer takes its other back end.
import * as THREE from 'three';
import { WebGPURenderer } from 'three/webgpu';
import { load } from 'penumbra-player';
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
    for (const one of [character, ground, character, ground]) one.dispose();
    out.after = await shot(here);
    asset.dispose();
    return out;
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
    found.after = apart(drawn.before, drawn.after);
    found.beside = Object.fromEntries(Object.keys(drawn).map((name) => [name, apart(reference[name], drawn[name]).mean]));
}

main()
    .catch((error) => (found.error = `${error.code ?? ''} ${error.stack}`))
    .finally(() => console.log('FOUND ' + JSON.stringify(found)));
