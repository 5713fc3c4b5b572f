// One frame of the demo's character by three.js with the clay and the camera of scripts/figures/compare_web.py, as a data URL.
import * as THREE from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { load } from 'penumbra-player';
import { PenumbraCharacter, PenumbraEnvironment, PenumbraLoader, assetOf } from 'penumbra-player/three';

const found = {};

async function main() {
    const look = await (await fetch('/files/look.json')).json();
    const renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    renderer.setSize(look.size, look.size);
    renderer.toneMapping = THREE.LinearToneMapping;
    renderer.toneMappingExposure = look.exposure;
    const scene = new THREE.Scene();
    const texture = await new EXRLoader().loadAsync('/files/city.exr');
    texture.mapping = THREE.EquirectangularReflectionMapping;
    scene.environment = texture;
    const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
    loader.register((parser) => new PenumbraLoader(parser, load()));
    const gltf = await loader.loadAsync('/files/man.glb');
    const { animations } = await loader.loadAsync('/files/walk.glb');
    scene.add(gltf.scene);
    const mixer = new THREE.AnimationMixer(gltf.scene);
    mixer.clipAction(animations[0]).play();
    mixer.setTime(look.seconds);
    const clay = new THREE.MeshPhysicalMaterial({ roughness: 1, specularIntensity: 0 });
    clay.color.setRGB(...look.albedo, THREE.LinearSRGBColorSpace);
    gltf.scene.traverse((mesh) => {
        if (!mesh.isMesh) return;
        mesh.material = clay;
        mesh.frustumCulled = false;
    });
    const character = new PenumbraCharacter(assetOf(gltf), gltf.scene, { environment: PenumbraEnvironment.fromEquirectangular(texture) });
    character.update();
    const [yaw, pitch] = [look.yaw, look.pitch].map((degrees) => (degrees * Math.PI) / 180);
    const camera = new THREE.PerspectiveCamera(look.fov, 1, 0.05, 50);
    camera.position.set(Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch));
    camera.position.multiplyScalar(look.distance).add(new THREE.Vector3(...look.target));
    camera.lookAt(...look.target);
    renderer.render(scene, camera);
    found.matchError = character.matchError;
    found.picture = renderer.domElement.toDataURL('image/png');
}

main()
    .catch((error) => (found.error = `${error.code ?? ''} ${error.stack}`))
    .finally(() => console.log('FOUND ' + JSON.stringify(found)));
