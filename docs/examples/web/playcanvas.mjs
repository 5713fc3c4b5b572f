// Soft self-shadows with PlayCanvas, by the core of penumbra-player (docs/web.md). E of each vertex becomes its colour,
// which darkens materials whose diffuseVertexColor is on.
import * as pc from 'playcanvas';
import { Character } from 'penumbra-player';

// Copies a mesh of the container into a mesh with room for colours.
function withColors(mesh, device) {
    const own = new pc.Mesh(device);
    const count = mesh.vertexBuffer.numVertices;
    for (const { name, numComponents, dataType, normalize, asInt } of mesh.vertexBuffer.format.elements) {
        const values = [];
        mesh.getVertexStream(name, values);
        own.setVertexStream(name, values, numComponents, count, dataType, normalize, asInt);
    }
    const indices = [];
    mesh.getIndices(indices);
    own.setIndices(indices);
    own.setColors(new Float32Array(4 * count).fill(1));
    own.update(pc.PRIMITIVE_TRIANGLES, false);
    own.aabb = mesh.aabb;
    own.skin = mesh.skin;
    return own;
}

/**
 * `entity` is what container.resource.instantiateRenderEntity() gave for the file of the bake, in the scene, `asset`
 * what runtime.open() gave for its .pnb. Answers what to call in each frame: app.on('update', attach(asset, entity)).
 */
export function attach(asset, entity) {
    const character = new Character(asset);
    const joints = asset.jointNames.map((name) => entity.findByName(name));
    const inverseBind = joints.map((_, j) => {
        const rows = [...asset.inverseBind.subarray(12 * j, 12 * j + 12), 0, 0, 0, 1];
        return new pc.Mat4().set(rows).transpose(); // PlayCanvas has columns
    });
    const meshes = [];
    for (const render of entity.findComponents('render'))
        render.meshInstances = render.meshInstances.map((before) => {
            before.material.diffuseVertexColor = true;
            before.material.update();
            meshes.push(withColors(before.mesh, before.mesh.vertexBuffer.device));
            const after = new pc.MeshInstance(meshes.at(-1), before.material, before.node);
            after.skinInstance = new pc.SkinInstance(before.mesh.skin); // `before` destroys its own skin instance
            after.skinInstance.bones = before.skinInstance.bones;
            return after;
        });
    const counts = meshes.map((mesh) => mesh.vertexBuffer.numVertices);
    const source = asset.sourceVertices; // the file's vertices, mesh after mesh
    if (counts.reduce((sum, count) => sum + count, 0) !== source.length) throw new Error('another file was baked');
    const [toModel, product] = [new pc.Mat4(), new pc.Mat4()];

    const update = () => {
        toModel.copy(entity.getWorldTransform()).invert();
        const matrices = character.poseMatrices;
        joints.forEach((joint, j) => {
            product.mul2(toModel, joint.getWorldTransform()).mul(inverseBind[j]);
            matrices.set(product.data, 16 * j);
        });
        character.setPose();
        character.evaluate();
        const e = character.ambient();
        let first = 0;
        meshes.forEach((mesh, m) => {
            const colors = new Float32Array(4 * counts[m]).fill(1);
            for (let i = 0; i < counts[m]; ++i) colors.fill(e[source[first + i]], 4 * i, 4 * i + 3);
            mesh.setColors(colors);
            mesh.update();
            first += counts[m];
        });
    };
    return Object.assign(update, { character });
}
