// Suns that become lights, light of PMREM textures, characters that darken one another, and grounds with many squares:
// what the test of Chromium looks at, for WebGLRenderer.
import * as THREE from 'three';
import { clone } from 'three/addons/utils/SkeletonUtils.js';
import { load } from 'penumbra-player';
import { PenumbraCharacter, PenumbraEnvironment, PenumbraGround, PenumbraScene } from 'penumbra-player/three';
import { SIZE, apart, pixelsOf, sky, stage, sunnySky } from './scene.mjs';

const found = {};

/** The largest difference of two lights, as a share of the largest number of the first. */
function lightsApart(a, b) {
    const [x, y] = [a.world, b.world];
    const most = x.reduce((largest, value) => Math.max(largest, Math.abs(value)), 0);
    return x.reduce((largest, value, i) => Math.max(largest, Math.abs(value - y[i])), 0) / most;
}

/** A level white floor under an environment and lights: its mean in 8-bit steps without tone mapping. */
function litFloor(renderer, environment, lights) {
    const scene = new THREE.Scene();
    scene.environment = environment;
    scene.add(new THREE.Mesh(new THREE.PlaneGeometry(9, 9).rotateX(-Math.PI / 2), new THREE.MeshLambertMaterial({ color: 0x404040 })));
    for (const light of lights) scene.add(light, light.target);
    const camera = new THREE.PerspectiveCamera(20, 1, 0.1, 50);
    camera.position.set(0, 4, 0);
    camera.lookAt(0, 0, 0);
    renderer.render(scene, camera);
    const pixels = pixelsOf(renderer.domElement);
    return [0, 1, 2].map((k) => pixels.reduce((sum, value, i) => (i % 4 === k ? sum + value : sum), 0) / (pixels.length / 4));
}

function checkSuns(renderer) {
    const irradiance = 2;
    const { texture, direction } = sunnySky(40, 26, irradiance);
    const [whole, split] = [0, 3].map((suns) => PenumbraEnvironment.fromEquirectangular(texture, { suns }));
    const light = split.lights[0];
    const turn = new THREE.Matrix4().makeRotationY(1.1);
    split.setRotation(turn);
    const turned = light.position.clone().normalize().angleTo(direction.clone().transformDirection(turn));
    split.setRotation(new THREE.Matrix4());
    const generator = new THREE.PMREMGenerator(renderer);
    const [bright, soft] = [texture, split.soft].map((picture) => generator.fromEquirectangular(picture).texture);
    found.suns = {
        count: split.lights.length,
        // A sky without a sun keeps all it has.
        ofSky: PenumbraEnvironment.fromEquirectangular(sky(), { suns: 3 }).lights.length,
        angle: light.position.clone().normalize().angleTo(direction),
        turned,
        irradiance: light.intensity * light.color.g,
        remainder: lightsApart(PenumbraEnvironment.fromEquirectangular(sky()), split),
        whole: litFloor(renderer, bright, []),
        split: litFloor(renderer, soft, [light]),
        twice: litFloor(renderer, bright, [light]),
        inside: lightsApart(whole, split),
    };
}

async function checkPmrem(renderer) {
    const [small, large] = [sky(), sunnySky(40, 26, 2).texture].map((texture, i) => ({ texture, scale: i === 0 ? 1 : 32 }));
    found.pmrem = [];
    for (const { texture, scale } of [small, large]) {
        const { width, height, data } = texture.image;
        // A large picture is read at a coarser step.
        const more = new THREE.DataTexture(new Float32Array(4 * width * height * scale ** 2), width * scale, height * scale, THREE.RGBAFormat, THREE.FloatType);
        for (let i = 0; i < more.image.data.length; ++i) {
            const [pixel, k] = [i >> 2, i % 4];
            const [x, y] = [Math.floor((pixel % (width * scale)) / scale), Math.floor(pixel / (width * scale) / scale)];
            more.image.data[i] = data[4 * (y * width + x) + k];
        }
        more.mapping = THREE.EquirectangularReflectionMapping;
        more.needsUpdate = true;
        const packed = new THREE.PMREMGenerator(renderer).fromEquirectangular(more).texture;
        const light = await PenumbraEnvironment.fromPMREM(renderer, packed);
        found.pmrem.push({ isCube: packed.isCubeTexture === true, apart: lightsApart(PenumbraEnvironment.fromEquirectangular(more), light) });
    }
    try {
        await PenumbraEnvironment.fromPMREM(renderer, sky());
    } catch (error) {
        found.pmremRefused = error.code;
    }
}

/** Two characters side by side: alone, and darkened by one another; then a ground under both, which stand apart. */
async function checkScene(runtime, renderer) {
    const { scene, root, floor, camera, texture, asset, environment } = await stage(runtime);
    scene.environment = texture;
    const copy = clone(root);
    copy.position.x += 0.5;
    scene.add(copy);
    const characters = [root, copy].map((one) => new PenumbraCharacter(asset, one, { environment }));
    const shot = () => {
        renderer.render(scene, camera);
        return pixelsOf(renderer.domElement);
    };
    const open = shot();
    for (const one of characters) one.update();
    const alone = shot();
    const both = new PenumbraScene(runtime, characters);
    both.update();
    const together = shot();
    found.self = apart(open, alone);
    found.others = apart(alone, together);
    // Far from one another they are as if alone.
    copy.position.x += 40;
    for (const one of characters) one.update();
    const far = shot();
    both.update();
    found.farApart = apart(far, shot());
    both.dispose();
    both.dispose();
    copy.position.x -= 39;
    for (const one of characters) one.update();
    const before = shot();
    const ground = new PenumbraGround(runtime, floor, characters, { environment, radius: 0.8 });
    ground.update();
    const under = shot();
    found.ground = apart(before, under);
    // Half of the picture for each character.
    const half = (pixels, right) => pixels.filter((_, i) => ((i >> 2) % SIZE >= SIZE / 2) === right);
    found.halves = [false, true].map((right) => apart(half(before, right), half(under, right)).changed);
    const one = new PenumbraGround(runtime, floor, [characters[0]], { environment, radius: 0.8 });
    ground.dispose();
    one.update();
    const single = shot();
    found.halvesOfOne = [false, true].map((right) => apart(half(before, right), half(single, right)).changed);
    one.dispose();
    for (const character of characters) character.dispose();
}

async function main() {
    const runtime = await load();
    const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
    renderer.setSize(SIZE, SIZE);
    document.body.append(renderer.domElement);
    checkSuns(renderer);
    await checkPmrem(renderer);
    await checkScene(runtime, renderer);
}

main()
    .catch((error) => (found.error = `${error.code ?? ''} ${error.stack}`))
    .finally(() => console.log('FOUND ' + JSON.stringify(found)));
