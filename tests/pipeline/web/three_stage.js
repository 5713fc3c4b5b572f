// Helpers for pages of three.js: the exported file in a scene, posed and drawn.
import * as THREE from 'three';
import {GLTFLoader} from '/node_modules/three/examples/jsm/loaders/GLTFLoader.js';

// Opens the case's file. pose(k) puts it into the moment k of the case and frames it; shot() draws it; colors(mesh, k)
// are the values that were baked for the moment k.
export async function openStage(about) {
  const gltf = await new GLTFLoader().loadAsync('/case/' + about.file);
  const scene = new THREE.Scene();
  scene.add(gltf.scene);
  const meshes = [];
  gltf.scene.traverse((o) => { if (o.isMesh) meshes.push(o); });
  const rows = new Map();
  for (const mesh of meshes) {
    mesh.frustumCulled = false;
    const at = gltf.parser.associations.get(mesh);
    rows.set(mesh, about.truth[at.meshes + '/' + at.primitives]);
  }
  const renderer = new THREE.WebGLRenderer({preserveDrawingBuffer: true});
  renderer.setSize(400, 400);
  renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
  document.body.appendChild(renderer.domElement);
  const camera = new THREE.OrthographicCamera();
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const pose = (k) => {
    mixer.stopAllAction();
    const action = mixer.clipAction(THREE.AnimationClip.findByName(gltf.animations, about.clips[k]));
    action.setLoop(THREE.LoopOnce).clampWhenFinished = true;  // or its last moment is its first one
    action.reset().play();
    mixer.setTime(about.times[k]);
    gltf.scene.updateMatrixWorld(true);
    const sphere = new THREE.Box3().setFromObject(gltf.scene, true).getBoundingSphere(new THREE.Sphere()), r = sphere.radius;
    Object.assign(camera, {left: -r, right: r, top: r, bottom: -r, near: 0, far: 6 * r});
    camera.updateProjectionMatrix();
    camera.position.copy(sphere.center).add(new THREE.Vector3(.5, .3, .8).setLength(3 * r));
    camera.lookAt(sphere.center);
  };
  const shot = () => {
    renderer.render(scene, camera);
    const gl = renderer.getContext(), p = new Uint8Array(4 * 400 * 400);
    gl.readPixels(0, 0, 400, 400, gl.RGBA, gl.UNSIGNED_BYTE, p);
    return p;
  };
  const colors = (mesh, k) => new THREE.BufferAttribute(new Float32Array(rows.get(mesh)[k].flatMap((x) => [x, x, x])), 3);
  return {meshes, pose, shot, colors, picture: () => renderer.domElement.toDataURL('image/png')};
}
