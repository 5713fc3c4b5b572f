// The example of docs/examples/web with Babylon.js: positions of the core are those that Babylon skins, and vertices
// darken.
import { Engine } from '@babylonjs/core/Engines/engine.js';
import { Scene } from '@babylonjs/core/scene.js';
import { ArcRotateCamera } from '@babylonjs/core/Cameras/arcRotateCamera.js';
import { HemisphericLight } from '@babylonjs/core/Lights/hemisphericLight.js';
import { Vector3 } from '@babylonjs/core/Maths/math.vector.js';
import { ImportMeshAsync } from '@babylonjs/core/Loading/sceneLoader.js';
import '@babylonjs/loaders/glTF/2.0/glTFLoader.js';
import { Character, load } from 'penumbra-player';
import { attach } from '/examples/web/babylon.mjs';

const found = {};

async function main() {
    const scene = new Scene(new Engine(document.getElementById('canvas'), false, { preserveDrawingBuffer: true }));
    new ArcRotateCamera('camera', 1, 1.2, 4, new Vector3(0, 0.9, 0), scene);
    new HemisphericLight('light', new Vector3(0, 1, 0), scene);
    const loaded = await ImportMeshAsync('/files/character.glb', scene);
    const asset = (await load()).open(await (await fetch('/files/composed.pnb')).arrayBuffer());
    loaded.animationGroups[0].start(true);
    loaded.animationGroups[0].goToFrame(10);
    loaded.animationGroups[0].pause();
    scene.render();
    const update = attach(asset, loaded);
    update();
    scene.render();
    const mesh = loaded.meshes.find((one) => one.getTotalVertices() > 0);
    const colors = mesh.getVerticesData('color');
    found.vertices = colors.length / 4;
    found.least = colors.reduce((least, value) => Math.min(least, value), 1);
    found.most = colors.reduce((most, value) => Math.max(most, value), 0);
    // Skinned by Babylon, in its left-handed scene, and by the core in the file's frame.
    const skinned = mesh.getPositionData(true);
    const probe = new Character(asset);
    probe.poseMatrices.set(update.character.poseMatrices);
    probe.setPose();
    probe.skin();
    const toModel = mesh.getWorldMatrix().multiply(loaded.meshes[0].getWorldMatrix().clone().invert());
    const { positions } = probe;
    const source = asset.sourceVertices;
    found.apart = 0;
    for (let i = 0; i < found.vertices; ++i) {
        const at = Vector3.TransformCoordinates(Vector3.FromArray(skinned, 3 * i), toModel);
        const d = Vector3.Distance(at, Vector3.FromArray(positions, 3 * source[i]));
        if (!(d <= found.apart)) found.apart = d;
    }
}

main()
    .catch((error) => (found.error = `${error.code ?? ''} ${error.stack}`))
    .finally(() => console.log('FOUND ' + JSON.stringify(found)));
