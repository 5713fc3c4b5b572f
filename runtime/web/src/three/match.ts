import { Matrix4, Quaternion, Vector3, type Bone, type Mesh, type Object3D, type SkinnedMesh } from 'three';
import type { Asset } from '../core.js';
import { PenumbraError } from '../error.js';

/** Which vertex of the asset each vertex of each mesh is, and how far they are apart at most, in diagonals. */
export interface Match {
    vertices: Uint32Array[];
    error: number;
    way: 'attribute' | 'order' | 'place';
}
export interface Poser {
    bones: Bone[];
    /**
     * Poses the asset as the bones are now: its positions and normals in the model frame, which the next call changes.
     */
    pose: () => { positions: Float32Array; normals: Float32Array };
}

// Vertices that are further apart are not the same, in diagonals: quantised files are off by a tenth of it.
const TOLERANCE = 3e-4;
const ATTRIBUTE = '_penumbra';

function positionsOf(mesh: Mesh, toModel: Matrix4): Float32Array {
    const count = mesh.geometry.attributes.position.count;
    const out = new Float32Array(3 * count);
    const matrix = new Matrix4().multiplyMatrices(toModel, mesh.matrixWorld);
    const at = new Vector3();
    for (let i = 0; i < count; ++i) mesh.getVertexPosition(i, at).applyMatrix4(matrix).toArray(out, 3 * i);
    return out;
}

/** Normals of a mesh as its bones are now, by the ends of short needles. */
function normalsOf(mesh: Mesh, toModel: Matrix4, length: number): Float32Array {
    const { position, normal } = mesh.geometry.attributes;
    const out = new Float32Array(3 * position.count);
    if (!normal) return out;
    const matrix = new Matrix4().multiplyMatrices(toModel, mesh.matrixWorld);
    const skinned = mesh as SkinnedMesh;
    const [from, to] = [new Vector3(), new Vector3()];
    for (let i = 0; i < position.count; ++i) {
        from.fromBufferAttribute(position, i);
        to.fromBufferAttribute(normal, i).multiplyScalar(length).add(from);
        for (const end of [from, to]) {
            if (skinned.isSkinnedMesh) skinned.applyBoneTransform(i, end);
            end.applyMatrix4(matrix);
        }
        to.sub(from).normalize().toArray(out, 3 * i);
    }
    return out;
}

function distance(a: Float32Array, i: number, b: Float32Array, j: number): number {
    return Math.hypot(a[3 * i] - b[3 * j], a[3 * i + 1] - b[3 * j + 1], a[3 * i + 2] - b[3 * j + 2]);
}

function diagonalOf(positions: Float32Array): number {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < positions.length; ++i) {
        low[i % 3] = Math.min(low[i % 3], positions[i]);
        high[i % 3] = Math.max(high[i % 3], positions[i]);
    }
    return Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

/** A pose that no clip has: it tells apart what touches in the first one. */
function bent<T>(root: Object3D, bones: Bone[], work: () => T): T {
    const before = bones.map((bone) => bone.quaternion.clone());
    const axis = new Vector3();
    bones.forEach((bone, i) => {
        axis.set(Math.sin(i), Math.cos(2 * i), Math.sin(3 * i + 1)).normalize();
        bone.quaternion.multiply(new Quaternion().setFromAxisAngle(axis, 0.15));
    });
    root.updateMatrixWorld(true);
    try {
        return work();
    } finally {
        bones.forEach((bone, i) => bone.quaternion.copy(before[i]));
        root.updateMatrixWorld(true);
    }
}

interface Pose {
    ours: Float32Array;
    theirs: Float32Array[];
    ourNormals: Float32Array;
    theirNormals: Float32Array[];
}

function worstOf(poses: Pose[], vertices: Uint32Array[]): number {
    let worst = 0;
    for (const { ours, theirs } of poses)
        theirs.forEach((positions, mesh) => {
            for (let i = 0; i < vertices[mesh].length; ++i) {
                const d = distance(positions, i, ours, vertices[mesh][i]);
                if (!(d <= worst)) worst = d;
            }
        });
    return worst;
}

/** The cosine between the normals of a vertex of a mesh and one of the asset. */
function alike(pose: Pose, mesh: number, i: number, k: number): number {
    const [a, b] = [pose.theirNormals[mesh], pose.ourNormals];
    return a[3 * i] * b[3 * k] + a[3 * i + 1] * b[3 * k + 1] + a[3 * i + 2] * b[3 * k + 2];
}

/** The asset's vertices by cells of twice the tolerance. */
function cellsOf(positions: Float32Array, cell: number): Map<string, number[]> {
    const cells = new Map<string, number[]>();
    for (let k = 0; k < positions.length / 3; ++k) {
        const key = [0, 1, 2].map((c) => Math.round(positions[3 * k + c] / cell)).join();
        const list = cells.get(key);
        if (list) list.push(k);
        else cells.set(key, [k]);
    }
    return cells;
}

function matchByPlace(poses: Pose[], tolerance: number): { vertices: Uint32Array[]; lost: number } {
    const cell = 2 * tolerance;
    const cells = cellsOf(poses[0].ours, cell);
    let lost = 0;
    const vertices = poses[0].theirs.map((positions, mesh) =>
        Uint32Array.from({ length: positions.length / 3 }, (_, i) => {
            const [x, y, z] = [0, 1, 2].map((c) => Math.round(positions[3 * i + c] / cell));
            let [best, least] = [-1, Infinity];
            for (let d = 0; d < 27; ++d)
                for (const k of cells.get([x + (d % 3) - 1, y + (Math.floor(d / 3) % 3) - 1, z + Math.floor(d / 9) - 1].join()) ?? []) {
                    const apart = Math.max(...poses.map((pose) => distance(pose.theirs[mesh], i, pose.ours, k)));
                    if (!(apart < tolerance)) continue;
                    // Among several at one place, the one that looks the same way is best.
                    const cost = apart + 0.5 * tolerance * (1 - alike(poses[0], mesh, i, k));
                    if (cost < least) [best, least] = [k, cost];
                }
            if (best < 0) ++lost;
            return Math.max(best, 0);
        }),
    );
    return { vertices, lost };
}

/** The orders that files keep: an attribute that tools carry along, or the vertices one mesh after the other. */
function knownOrders(asset: Asset, meshes: Mesh[]): [Match['way'], Uint32Array[]][] {
    const source = asset.sourceVertices;
    const orders: [Match['way'], Uint32Array[]][] = [];
    const own = meshes.map((mesh) => mesh.geometry.getAttribute(ATTRIBUTE));
    if (own.every((attribute) => attribute))
        orders.push(['attribute', own.map((a) => Uint32Array.from({ length: a.count }, (_, i) => source[a.getX(i)]))]);
    const counts = meshes.map((mesh) => mesh.geometry.attributes.position.count);
    let first = 0;
    if (counts.reduce((sum, count) => sum + count, 0) === source.length)
        orders.push(['order', counts.map((count) => source.subarray(first, (first += count)))]);
    return orders;
}

/** Finds the vertices, and checks each by its place in two poses. Throws UNMATCHED where some cannot be found. */
export function matchVertices(asset: Asset, root: Object3D, meshes: Mesh[], poser: Poser): Match {
    const toModel = new Matrix4();
    const pose = (): Pose => {
        toModel.copy(root.matrixWorld).invert();
        const theirs = meshes.map((mesh) => positionsOf(mesh, toModel));
        const { positions, normals } = poser.pose();
        const needle = 1e-3 * diagonalOf(positions);
        const theirNormals = meshes.map((mesh) => normalsOf(mesh, toModel, needle));
        return { ours: positions.slice(), theirs, ourNormals: normals.slice(), theirNormals };
    };
    const poses = [pose(), bent(root, poser.bones, pose)];
    const diagonal = diagonalOf(poses[0].ours);
    for (const [way, vertices] of knownOrders(asset, meshes)) {
        const worst = worstOf(poses, vertices);
        if (worst <= TOLERANCE * diagonal) return { vertices, error: worst / diagonal, way };
    }
    const { vertices, lost } = matchByPlace(poses, TOLERANCE * diagonal);
    if (lost > 0)
        throw new PenumbraError(
            'UNMATCHED',
            `${lost} of ${vertices.reduce((sum, list) => sum + list.length, 0)} vertices are not in the asset: it was baked from another mesh`,
        );
    return { vertices, error: worstOf(poses, vertices) / diagonal, way: 'place' };
}
