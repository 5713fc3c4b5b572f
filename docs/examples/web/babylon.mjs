// Soft self-shadows with Babylon.js, by the core of penumbra-player (docs/web.md). E of each vertex becomes its colour,
// which darkens the base colour: a material of your own can read it as occlusion of ambient light alone.
import { Matrix } from '@babylonjs/core/Maths/math.vector.js';
import { VertexBuffer } from '@babylonjs/core/Buffers/buffer.js';
import { Character } from 'penumbra-player';

/**
 * `loaded` is what ImportMeshAsync gave for the file of the bake, `asset` what runtime.open() gave for its .pnb.
 * Answers what to call in each frame: scene.onBeforeRenderObservable.add(attach(asset, loaded)).
 */
export function attach(asset, loaded) {
    const character = new Character(asset);
    const root = loaded.meshes[0]; // it turns the file into Babylon's left-handed scene
    const nodes = new Map(loaded.skeletons[0].bones.map((bone) => [bone.getTransformNode().name, bone.getTransformNode()]));
    const joints = asset.jointNames.map((name) => nodes.get(name));
    const inverseBind = joints.map((_, j) => {
        const rows = [...asset.inverseBind.subarray(12 * j, 12 * j + 12), 0, 0, 0, 1];
        return Matrix.FromArray(rows).transpose(); // Babylon's matrices act on rows
    });
    const meshes = loaded.meshes.filter((mesh) => mesh.getTotalVertices() > 0);
    const source = asset.sourceVertices; // the file's vertices, mesh after mesh
    if (meshes.reduce((sum, mesh) => sum + mesh.getTotalVertices(), 0) !== source.length) throw new Error('another file was baked');
    for (const mesh of meshes) mesh.hasVertexAlpha = false;

    const update = () => {
        const toModel = root.computeWorldMatrix(true).clone().invert();
        const matrices = character.poseMatrices;
        joints.forEach((node, j) =>
            inverseBind[j].multiply(node.computeWorldMatrix(true)).multiply(toModel).copyToArray(matrices, 16 * j),
        );
        character.setPose();
        character.evaluate();
        const e = character.ambient();
        let first = 0;
        for (const mesh of meshes) {
            const count = mesh.getTotalVertices();
            const colors = new Float32Array(4 * count).fill(1);
            for (let i = 0; i < count; ++i) colors.fill(e[source[first + i]], 4 * i, 4 * i + 3);
            mesh.setVerticesData(VertexBuffer.ColorKind, colors, true);
            first += count;
        }
    };
    return Object.assign(update, { character });
}
