// Helpers for pages of three.js: a sky, a scene with a character on a ground, and differences of pictures.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { PenumbraEnvironment, PenumbraLoader, assetOf } from 'penumbra-player/three';

export const SIZE = 256;

/** A blue sky that is bright on one side, over a dark ground. */
export function sky() {
    const [width, height] = [64, 32];
    const data = new Float32Array(4 * width * height);
    for (let i = 0; i < width * height; ++i) {
        const up = ((Math.floor(i / width) + 0.5) / height - 0.5) * Math.PI;
        const around = (((i % width) + 0.5) / width - 0.5) * 2 * Math.PI;
        const warm = Math.max(0, Math.cos(around) * Math.cos(up)) ** 4;
        data.set(up < 0 ? [0.05, 0.05, 0.05, 1] : [0.4 + 3 * warm, 0.6 + 2 * warm, 1 + warm, 1], 4 * i);
    }
    const texture = new THREE.DataTexture(data, width, height, THREE.RGBAFormat, THREE.FloatType);
    texture.mapping = THREE.EquirectangularReflectionMapping;
    texture.needsUpdate = true;
    return texture;
}

/** The character of the files with its asset, turned and moved, on a ground; a camera that sees both. */
export async function stage(runtime) {
    const loader = new GLTFLoader();
    loader.register((parser) => new PenumbraLoader(parser, runtime));
    const gltf = await loader.loadAsync('/files/character.glb');
    const scene = new THREE.Scene();
    scene.background = new THREE.Color(0x404040); // canvases differ in how they clear
    const root = gltf.scene;
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(6, 6).rotateX(-Math.PI / 2), new THREE.MeshStandardMaterial());
    scene.add(root, floor);
    root.rotation.y = 0.7;
    root.position.set(0.3, 0, -0.2);
    const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 50);
    camera.position.set(1.5, 1.6, 3.5);
    camera.lookAt(0.2, 0.8, 0);
    const mixer = new THREE.AnimationMixer(root);
    mixer.clipAction(gltf.animations[0]).play();
    mixer.setTime(0.4);
    root.traverse((object) => (object.frustumCulled = false));
    const texture = sky();
    return { scene, root, floor, camera, texture, asset: assetOf(gltf), environment: PenumbraEnvironment.fromEquirectangular(texture) };
}

/** How two pictures differ, in 8-bit steps: the mean, and the shares of numbers that changed, or became brighter. */
export function apart(a, b) {
    let [sum, changed, brighter] = [0, 0, 0];
    for (let i = 0; i < a.length; ++i) {
        sum += Math.abs(a[i] - b[i]);
        if (Math.abs(a[i] - b[i]) > 2) ++changed;
        if (b[i] > a[i] + 2) ++brighter;
    }
    return { mean: sum / a.length, changed: changed / a.length, brighter: brighter / a.length };
}

/** The pixels of a canvas that was drawn in this turn of the page. */
export function pixelsOf(canvas) {
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const paint = copy.getContext('2d');
    paint.drawImage(canvas, 0, 0);
    return paint.getImageData(0, 0, canvas.width, canvas.height).data;
}
