// A character with soft shadows in three.js: what the test of Chromium looks at. Says its findings as JSON.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { mergeVertices } from 'three/addons/utils/BufferGeometryUtils.js';
import { load } from 'penumbra-player';
import { PenumbraCharacter, PenumbraEnvironment, PenumbraGround, PenumbraLoader, assetOf } from 'penumbra-player/three';
import { SIZE, apart, sky } from './scene.mjs';

const found = {};

/** The same triangles with the vertices the other way round. */
function reversed(geometry) {
    const out = geometry.clone();
    const count = geometry.attributes.position.count;
    for (const [name, attribute] of Object.entries(geometry.attributes)) {
        const size = attribute.itemSize;
        const values = new Float32Array(size * count);
        for (let i = 0; i < count; ++i)
            for (let k = 0; k < size; ++k) values[size * i + k] = attribute.getComponent(count - 1 - i, k);
        out.setAttribute(name, new THREE.BufferAttribute(values, size));
    }
    const index = geometry.index ? Array.from(geometry.index.array) : Array.from({ length: count }, (_, i) => i);
    out.setIndex(index.map((i) => count - 1 - i));
    return out;
}

/** One vertex for all that are at one place: normals and textures are lost, as welding tools lose some. */
function welded(geometry) {
    const out = geometry.clone();
    for (const name of Object.keys(out.attributes))
        if (!['position', 'skinIndex', 'skinWeight'].includes(name)) out.deleteAttribute(name);
    return mergeVertices(out);
}

/** Positions of 16 bits, whose scale the skeleton has, as KHR_mesh_quantization does it. Answers what undoes it. */
function quantise(mesh) {
    const geometry = mesh.geometry.clone();
    geometry.computeBoundingBox();
    const { min, max } = geometry.boundingBox;
    const size = Math.max(...max.clone().sub(min).toArray());
    const position = geometry.attributes.position;
    const step = size / 65535;
    const values = new Uint16Array(3 * position.count);
    for (let i = 0; i < position.count; ++i)
        for (let k = 0; k < 3; ++k) values[3 * i + k] = Math.round((position.getComponent(i, k) - min.getComponent(k)) / step);
    geometry.setAttribute('position', new THREE.BufferAttribute(values, 3, true));
    const larger = new THREE.Matrix4().makeScale(size, size, size).setPosition(min);
    const before = { geometry: mesh.geometry, bind: mesh.bindMatrix.clone() };
    mesh.geometry = geometry;
    mesh.bindMatrix.multiply(larger);
    return () => {
        mesh.geometry = before.geometry;
        mesh.bindMatrix.copy(before.bind);
    };
}

const matchOf = (asset, root, environment) => {
    const character = new PenumbraCharacter(asset, root, { environment });
    character.dispose();
    return { error: character.matchError, by: character.matchedBy };
};

async function main() {
    const runtime = await load();
    const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
    renderer.setSize(SIZE, SIZE);
    document.body.append(renderer.domElement);
    const scene = new THREE.Scene();
    const texture = sky();
    scene.environment = new THREE.PMREMGenerator(renderer).fromEquirectangular(texture).texture;
    const environment = PenumbraEnvironment.fromEquirectangular(texture);

    const loader = new GLTFLoader();
    const plain = await loader.loadAsync('/files/character.glb');
    found.plainLoads = !!plain.scene && assetOf(plain) === undefined;
    loader.register((parser) => new PenumbraLoader(parser, runtime));
    const gltf = await loader.loadAsync('/files/character.glb');
    const asset = assetOf(gltf);
    const root = gltf.scene;
    scene.add(root);
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(6, 6).rotateX(-Math.PI / 2), new THREE.MeshStandardMaterial());
    scene.add(floor);
    // A turned and moved character must not matter.
    root.rotation.y = 0.7;
    root.position.set(0.3, 0, -0.2);
    const mixer = new THREE.AnimationMixer(root);
    mixer.clipAction(gltf.animations[0]).play();
    mixer.setTime(0.3);
    const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 50);
    camera.position.set(2.2, 1.8, 3.2);
    camera.lookAt(0.3, 0.7, -0.2);

    const shot = () => {
        renderer.render(scene, camera);
        const pixels = new Uint8Array(4 * SIZE * SIZE);
        const gl = renderer.getContext();
        gl.readPixels(0, 0, SIZE, SIZE, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        return pixels;
    };
    const before = shot();
    let calls = 0;
    const meshes = [];
    root.traverse((object) => object.isMesh && meshes.push(object));
    meshes[0].material.onBeforeCompile = () => ++calls;
    meshes[0].material.needsUpdate = true;
    const character = new PenumbraCharacter(asset, root, { environment });
    found.matchError = character.matchError;
    found.matchedBy = character.matchedBy;
    character.update();
    const shadowed = shot();
    found.onCharacter = apart(before, shadowed);
    found.ownCompileRan = calls > 0;
    character.strength = 0;
    character.update();
    found.strength0 = apart(before, shot());
    character.strength = 1;
    character.update();
    const ground = new PenumbraGround(runtime, floor, [character], { environment, every: 1 });
    ground.update();
    found.onGround = apart(shadowed, shot());
    const first = performance.now();
    for (let i = 0; i < 5; ++i) character.update();
    found.updateMs = (performance.now() - first) / 5;
    environment.setRotation(new THREE.Matrix4().makeRotationY(2));
    scene.environmentRotation.set(0, 2, 0);
    character.update();
    ground.update();
    found.turned = apart(shadowed, shot());
    environment.setRotation(new THREE.Matrix4());
    scene.environmentRotation.set(0, 0, 0);
    character.dispose();
    character.dispose();
    ground.dispose();
    ground.dispose();
    found.afterDispose = apart(before, shot());

    const own = floor.material.onBeforeCompile;
    const grounds = [0, 1, 2].map(() => new PenumbraGround(runtime, floor, []));
    for (const i of [1, 2, 0]) grounds[i].dispose();
    found.unwrapped = floor.material.onBeforeCompile === own;

    const originals = meshes.map((mesh) => mesh.geometry);
    for (const mesh of meshes) mesh.geometry = reversed(mesh.geometry);
    const other = new PenumbraCharacter(asset, root, { environment });
    found.reversed = { error: other.matchError, by: other.matchedBy };
    other.update();
    found.reversedPicture = apart(shadowed, shot());
    other.dispose();
    for (const [i, mesh] of meshes.entries()) mesh.geometry = welded(originals[i]);
    found.welded = matchOf(asset, root, environment);
    for (const [i, mesh] of meshes.entries()) mesh.geometry = originals[i].toNonIndexed();
    found.split = matchOf(asset, root, environment);
    meshes.forEach((mesh, i) => (mesh.geometry = originals[i]));
    const undo = meshes.map(quantise);
    found.quantised = matchOf(asset, root, environment);
    for (const one of undo) one();

    for (let i = 0; i < 10; ++i) matchOf(asset, root, environment);
    const bytes = runtime.memoryBytes;
    const { geometries } = renderer.info.memory;
    for (let i = 0; i < 1000; ++i) {
        matchOf(asset, root, environment);
        if (i % 100 === 0) shot();
    }
    found.grown = [runtime.memoryBytes - bytes, renderer.info.memory.geometries - geometries];

    meshes.forEach((mesh, i) => (mesh.geometry = originals[i].clone()));
    const positions = meshes[0].geometry.attributes.position;
    positions.setX(0, positions.getX(0) + 0.5);
    try {
        new PenumbraCharacter(asset, root, { environment });
        found.unmatched = 'accepted';
    } catch (error) {
        found.unmatched = error.code;
    }
}

main()
    .catch((error) => (found.error = `${error.code ?? ''} ${error.stack}`))
    .finally(() => console.log('FOUND ' + JSON.stringify(found)));
