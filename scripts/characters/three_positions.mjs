// Where three.js puts the vertices of a glTF file: node three_positions.mjs MODULES FILE REQUEST OUT
//
// MODULES is the node_modules folder that has the npm package three. REQUEST is a JSON list of frames [[clip, seconds],
// ...]; clip is an index into the animations of the file, or -1 for the file as it stands. OUT gets frames x vertices x
// 3 little-endian doubles, world space, in the order of node, primitive and vertex. NaN stands for vertices that no
// triangle with an area uses, and for those whose weights are all 0, of which glTF says nothing. Prints one line of
// JSON: {"clips": [[name, seconds], ...], "vertices", "three_apart"}. With an empty REQUEST that line is all.
//
// three.js reads the file, moves the nodes and says where the bones are. The sum over targets and bones is done here in
// doubles, because three.js takes four bones a vertex only; "three_apart" is the largest distance from its own sum
// among every 97th vertex of four bones or fewer.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, file, requestFile, outFile] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(path.join(modules, 'three', name)));

globalThis.self = globalThis;
globalThis.ProgressEvent ??= class extends Event {};
console.warn = () => {};
const THREE = await load('build/three.module.js');
const { GLTFLoader } = await load('examples/jsm/loaders/GLTFLoader.js');
const { MeshoptDecoder } = await load('examples/jsm/libs/meshopt_decoder.module.js');
THREE.SkinnedMesh.prototype.normalizeSkinWeights = function () {};  // done below, over all sets

function readFile(name) {
    const bytes = fs.readFileSync(name);
    if (bytes.toString('latin1', 0, 4) !== 'glTF') return { json: JSON.parse(bytes), body: null };
    const length = bytes.readUInt32LE(12);
    const json = JSON.parse(bytes.toString('utf8', 20, 20 + length));
    const at = 20 + length;
    return { json, body: at + 8 <= bytes.length ? bytes.subarray(at + 8, at + 8 + bytes.readUInt32LE(at)) : null };
}

function bufferOf({ json, body }, index) {
    const uri = json.buffers[index].uri;
    if (uri === undefined) return body;
    if (!uri.startsWith('data:')) return fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)));
    const [head, data] = uri.split(/,(.*)/s);
    return Buffer.from(head.endsWith(';base64') ? data : decodeURIComponent(data), 'base64');
}

// Positions need no pictures, and node has nothing that opens them.
function withoutPictures(value) {
    if (Array.isArray(value)) return value.map(withoutPictures);
    if (value === null || typeof value !== 'object') return value;
    const kept = Object.entries(value).filter(([key]) => !/Texture$/.test(key));
    return Object.fromEntries(kept.map(([key, inner]) => [key, withoutPictures(inner)]));
}

const source = readFile(file);
const { textures, images, samplers, ...json } = source.json;
if (json.materials) json.materials = withoutPictures(json.materials);
let parser;
const loader = new GLTFLoader();
loader.setMeshoptDecoder(MeshoptDecoder);
loader.register((of_file) => {
    parser = of_file;
    parser.loadBuffer = async (index) => {
        const bytes = bufferOf(source, index);
        return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
    };
    return { name: 'penumbra_no_pictures' };
});
const gltf = await new Promise((done, failed) => loader.parse(JSON.stringify(json), '', done, failed));

// Nodes that KHR_node_visibility hides, with all that is below them.
const hidden = new Set();
const hide = (n) => { hidden.add(n); (json.nodes[n].children ?? []).forEach(hide); };
(json.nodes ?? []).forEach((node, n) => { if (node.extensions?.KHR_node_visibility?.visible === false) hide(n); });

const scene = gltf.scene ?? new THREE.Group();
if (!gltf.scene) {
    const children = new Set((json.nodes ?? []).flatMap((node) => node.children ?? []));
    for (const n of (json.nodes ?? []).keys()) if (!children.has(n)) scene.add(await parser.getDependency('node', n));
}

// The drawn primitives: {node, primitive, mesh, definition}, in the order of the file. (parser.associations cannot tell
// the nodes of one mesh apart.)
const objects = await Promise.all((json.nodes ?? []).map((_, n) => parser.getDependency('node', n)));
const drawn = new Set();
scene.traverse((object) => drawn.add(object));
const parts = [];
for (const [node, object] of objects.entries()) {
    if (json.nodes[node].mesh === undefined || hidden.has(node) || !drawn.has(object)) continue;
    const meshes = [];
    const find = (below) => {
        if (below.isMesh || below.isLine || below.isPoints) meshes.push(below);
        for (const child of below.children) if (!objects.includes(child)) find(child);
    };
    find(object);
    json.meshes[json.nodes[node].mesh].primitives.forEach((definition, primitive) => {
        if ((definition.mode ?? 4) >= 4) parts.push({ node, primitive, mesh: meshes[primitive], definition });
    });
}

async function values(index, width) {
    const attribute = await parser.getDependency('accessor', index);
    const out = new Float64Array(attribute.count * width);
    const get = ['getX', 'getY', 'getZ', 'getW'];
    for (let i = 0; i < attribute.count; ++i)
        for (let k = 0; k < width; ++k) out[i * width + k] = attribute[get[k]](i);
    return out;
}

async function readPart(part) {
    const { attributes, targets } = part.definition;
    part.positions = await values(attributes.POSITION, 3);
    part.count = part.positions.length / 3;
    part.targets = [];
    for (const target of targets ?? [])
        part.targets.push(target.POSITION === undefined ? null : await values(target.POSITION, 3));
    const { indices, mode = 4 } = part.definition;
    const order = indices === undefined ? Array.from({ length: part.count }, (_, v) => v) : await values(indices, 1);
    part.triangles = [];
    for (let k = 0; k + 2 < order.length; k += mode === 4 ? 3 : 1)
        part.triangles.push([order[mode === 6 ? 0 : k], order[k + 1], order[k + 2]]);
    part.sets = [];
    for (let n = 0; part.mesh.isSkinnedMesh && attributes[`JOINTS_${n}`] !== undefined; ++n)
        part.sets.push([await values(attributes[`JOINTS_${n}`], 4), await values(attributes[`WEIGHTS_${n}`], 4)]);
}

for (const part of parts) await readPart(part);
const instances = (part) => (part.mesh.isInstancedMesh ? part.mesh.count : 1);
const vertices = parts.reduce((sum, part) => sum + part.count * instances(part), 0);
// Rotations are unit quaternions in glTF. three.js takes them as they are and would scale by what they lack.
scene.traverse((object) => object.quaternion.normalize());
for (const track of gltf.animations.flatMap((clip) => clip.tracks)) {
    if (track.ValueTypeName !== 'quaternion' || track.values.length !== 4 * track.times.length) continue;
    track.values = Float32Array.from(track.values);
    for (let k = 0; k < track.values.length; k += 4) {
        const length = Math.hypot(...track.values.subarray(k, k + 4));
        if (length > 0) for (let i = k; i < k + 4; ++i) track.values[i] /= length;
    }
}
const clips = gltf.animations.map((clip) => [clip.name, clip.duration]);

function morphed(part) {
    const out = Float64Array.from(part.positions);
    const weights = part.mesh.morphTargetInfluences ?? [];
    part.targets.forEach((target, t) => {
        const weight = weights[t] ?? 0;
        if (target && weight !== 0) for (let i = 0; i < out.length; ++i) out[i] += weight * target[i];
    });
    return out;
}

// out[at..at+2] = sum of weight x matrix x (x, y, z), over the sum of the weights
function skin(part, bones, v, [x, y, z], out, at) {
    let sum = 0;
    const to = [0, 0, 0];
    for (const [joints, weights] of part.sets)
        for (let k = 4 * v; k < 4 * v + 4; ++k) {
            const m = bones[joints[k]];
            const w = weights[k];
            if (w === 0) continue;
            sum += w;
            for (let r = 0; r < 3; ++r) to[r] += w * (m[r] * x + m[r + 4] * y + m[r + 8] * z + m[r + 12]);
        }
    for (let r = 0; r < 3; ++r) out[at + r] = sum > 0 ? to[r] / sum : NaN;
}

let three_apart = 0;
function compare(part, v, out, at) {
    if (part.sets.length > 1 || part.mesh.isInstancedMesh || part.targets.includes(null) || v % 97) return;
    const weights = part.sets[0]?.[1].slice(4 * v, 4 * v + 4) ?? [1];
    if (Math.abs(weights.reduce((a, b) => a + b) - 1) > 1e-6) return;
    const theirs = part.mesh.getVertexPosition(v, new THREE.Vector3()).applyMatrix4(part.mesh.matrixWorld);
    const apart = Math.hypot(theirs.x - out[at], theirs.y - out[at + 1], theirs.z - out[at + 2]);
    if (Number.isFinite(apart)) three_apart = Math.max(three_apart, apart);
}

// Writes NaN over the vertices of a part that only triangles without area use, as they stand now.
function forget(part, places) {
    const place = (v) => places.subarray(3 * v, 3 * v + 3);
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < places.length; ++i) {
        if (places[i] < low[i % 3]) low[i % 3] = places[i];
        if (places[i] > high[i % 3]) high[i % 3] = places[i];
    }
    const least = 2e-6 * Math.hypot(...high.map((h, i) => h - low[i]));
    const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) > least;
    const used = new Uint8Array(part.count);
    for (const [a, b, c] of part.triangles)
        if (apart(place(a), place(b)) && apart(place(b), place(c)) && apart(place(c), place(a)))
            used[a] = used[b] = used[c] = 1;
    for (let v = 0; v < part.count; ++v) if (!used[v]) place(v).fill(NaN);
}

function writePart(part, out, at) {
    const rest = morphed(part);
    const skeleton = part.sets.length ? part.mesh.skeleton : null;
    const bones = skeleton?.bones.map((bone, j) =>
        new THREE.Matrix4().multiplyMatrices(bone.matrixWorld, skeleton.boneInverses[j]).elements);
    for (let i = 0; i < instances(part); ++i) {
        const world = part.mesh.matrixWorld.clone();
        if (part.mesh.isInstancedMesh) {
            const own = new THREE.Matrix4();
            part.mesh.getMatrixAt(i, own);
            world.multiply(own);
        }
        const m = world.elements;
        for (let v = 0; v < part.count; ++v, at += 3) {
            const p = rest.subarray(3 * v, 3 * v + 3);
            if (bones) skin(part, bones, v, p, out, at);
            else for (let r = 0; r < 3; ++r) out[at + r] = m[r] * p[0] + m[r + 4] * p[1] + m[r + 8] * p[2] + m[r + 12];
            compare(part, v, out, at);
        }
        forget(part, out.subarray(at - 3 * part.count, at));
    }
    return at;
}

const request = JSON.parse(fs.readFileSync(requestFile));
const mixer = new THREE.AnimationMixer(scene);
const output = fs.openSync(outFile, 'w');
let playing = -1;
for (const [clip, seconds] of request) {
    if (clip !== playing) mixer.stopAllAction();
    if (clip >= 0) {
        const action = mixer.clipAction(gltf.animations[clip]).setLoop(THREE.LoopOnce);
        action.clampWhenFinished = true;
        action.play();
        action.time = seconds;
        mixer.update(0);
    }
    playing = clip;
    scene.updateMatrixWorld(true);
    const out = new Float64Array(3 * vertices);
    let at = 0;
    for (const part of parts) at = writePart(part, out, at);
    fs.writeSync(output, Buffer.from(out.buffer));
}
fs.closeSync(output);
console.log(JSON.stringify({ clips, vertices, three_apart }));
