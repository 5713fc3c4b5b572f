import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Matrix4, type Bone, type Material, type Mesh, type Object3D } from 'three';
import { Character, type Asset, type Quality } from '../core.js';
import { PenumbraError } from '../error.js';
import { openIrradiance, visibleIrradiance } from '../sh.js';
import type { PenumbraEnvironment } from './environment.js';
import { matchVertices, type Match } from './match.js';
import { BY_VERTEX, patchMaterial } from './materials.js';

const ORDER = 5;

interface Part {
    mesh: Mesh;
    before: BufferGeometry;
    loss: BufferAttribute;
    vertices: Uint32Array;
}

function nameOf(object: Object3D): string {
    return (object.userData.name as string | undefined) ?? object.name; // three.js changes names for its animation paths
}

function meshesOf(root: Object3D): Mesh[] {
    const meshes: Mesh[] = [];
    root.traverse((object) => {
        const mesh = object as Mesh;
        if (mesh.isMesh && mesh.geometry.attributes.position) meshes.push(mesh);
    });
    return meshes;
}

function bonesOf(root: Object3D, names: readonly string[]): Bone[] {
    const found = new Map<string, Object3D>();
    root.traverse((object) => found.set(nameOf(object), object));
    return names.map((name) => {
        const bone = found.get(name);
        if (!bone) throw new PenumbraError('UNMATCHED', `the object has no '${name}', which is a joint of the asset`);
        return bone as Bone;
    });
}

/** The same attributes in a geometry of its own, so that characters can share the others. */
function ownGeometry(geometry: BufferGeometry, loss: BufferAttribute): BufferGeometry {
    const own = new BufferGeometry();
    own.setIndex(geometry.index);
    for (const [name, attribute] of Object.entries(geometry.attributes)) own.setAttribute(name, attribute);
    own.morphAttributes = geometry.morphAttributes;
    own.morphTargetsRelative = geometry.morphTargetsRelative;
    own.groups = geometry.groups;
    own.drawRange = geometry.drawRange;
    own.boundingBox = geometry.boundingBox;
    own.boundingSphere = geometry.boundingSphere;
    own.userData = geometry.userData;
    own.setAttribute('penumbraLoss', loss);
    return own;
}

export interface PenumbraCharacterOptions {
    environment?: PenumbraEnvironment;
    quality?: Quality;
    /** The meshes of the bake, in its order (default: all under the root, in theirs). */
    meshes?: Mesh[];
}

/** Soft self-shadows of an object that the asset was baked from. Its materials stay its own: the light of the
 * environment on them is darkened, in colour, where the character hides it from itself. */
export class PenumbraCharacter {
    readonly character: Character;
    /** Largest distance between vertices of the file and of the asset, in diagonals. */
    readonly matchError: number;
    readonly matchedBy: Match['way'];
    /** Values of the asset's inputs by name; those of morph targets come from the meshes. */
    readonly inputs = new Map<string, number>();
    /** From 0 (as without Penumbra) to 1. */
    strength = 1;
    private readonly parts: Part[];
    private readonly bones: Bone[];
    private readonly undo: (() => void)[];
    private readonly inverseBind: Matrix4[];
    private readonly toModel = new Matrix4();
    private readonly scratch = new Matrix4();
    private readonly open: Float32Array;
    private readonly visible: Float32Array;
    private readonly loss: Float32Array;
    private environment: PenumbraEnvironment | undefined;

    constructor(
        readonly asset: Asset,
        readonly root: Object3D,
        options: PenumbraCharacterOptions = {},
    ) {
        const inverseBind = asset.inverseBind;
        if (asset.deforming || inverseBind.length === 0)
            throw new PenumbraError('UNSUPPORTED', 'the asset has no bones that pose it');
        this.inverseBind = asset.jointNames.map((_, j) => {
            const rows = Array.from(inverseBind.subarray(12 * j, 12 * j + 12)).concat([0, 0, 0, 1]);
            return new Matrix4().fromArray(rows).transpose();
        });
        const inputJoints = asset.inputCount > 0 ? asset.jointNames.filter((name) => asset.inputNames.includes(name)).length : 0;
        this.bones = bonesOf(root, asset.jointNames.slice(0, asset.jointNames.length - inputJoints));
        this.environment = options.environment;
        const meshes = options.meshes ?? meshesOf(root);
        this.character = new Character(asset);
        this.open = new Float32Array(3 * asset.vertexCount);
        this.visible = new Float32Array(3 * asset.vertexCount);
        this.loss = new Float32Array(4 * asset.vertexCount);
        let match: Match;
        try {
            if (options.quality) this.character.setQuality(options.quality);
            root.updateMatrixWorld(true);
            match = matchVertices(asset, root, meshes, { bones: this.bones, pose: () => this.skinned(meshes) });
        } catch (error) {
            this.character.dispose();
            throw error;
        }
        this.matchError = match.error;
        this.matchedBy = match.way;
        this.parts = meshes.map((mesh, i) => {
            const loss = new BufferAttribute(new Float32Array(4 * match.vertices[i].length), 4).setUsage(DynamicDrawUsage);
            const before = mesh.geometry;
            mesh.geometry = ownGeometry(before, loss);
            return { mesh, before, loss, vertices: match.vertices[i] };
        });
        const materials = new Set<Material>(meshes.flatMap((mesh) => mesh.material));
        this.undo = [...materials].map((material) => patchMaterial(material, BY_VERTEX));
    }

    setEnvironment(environment: PenumbraEnvironment | undefined): void {
        this.environment = environment;
    }

    /** Computes the shadows of the pose that the bones have now: once a frame, after the mixer. */
    update(): void {
        this.root.updateMatrixWorld(true);
        this.pose(this.parts.map((part) => part.mesh));
        this.character.evaluate();
        this.computeLoss();
        for (const { loss, vertices } of this.parts) {
            const out = loss.array as Float32Array;
            for (let i = 0; i < vertices.length; ++i) {
                const from = 4 * vertices[i];
                out[4 * i] = this.loss[from];
                out[4 * i + 1] = this.loss[from + 1];
                out[4 * i + 2] = this.loss[from + 2];
                out[4 * i + 3] = this.loss[from + 3];
            }
            loss.needsUpdate = true;
        }
    }

    /** Where the character's first bone is, in the world. */
    get bodyWorld(): Matrix4 {
        return this.bones[0].matrixWorld;
    }

    /** Gives memory back, and the meshes their geometries and materials. A second call does nothing. */
    dispose(): void {
        if (this.character.disposed) return;
        for (const undo of this.undo) undo();
        for (const { mesh, before } of this.parts) {
            mesh.geometry.dispose();
            mesh.geometry = before;
        }
        this.character.dispose();
    }

    private pose(meshes: Mesh[]): void {
        this.toModel.copy(this.root.matrixWorld).invert();
        if (this.asset.inputCount > 0) this.character.setInputs(this.inputValues(meshes));
        const matrices = this.character.poseMatrices;
        this.bones.forEach((bone, j) => {
            this.scratch.multiplyMatrices(this.toModel, bone.matrixWorld).multiply(this.inverseBind[j]);
            this.scratch.toArray(matrices, 16 * j);
        });
        this.character.setPose();
    }
    private skinned(meshes: Mesh[]): { positions: Float32Array; normals: Float32Array } {
        this.pose(meshes);
        this.character.skin();
        return { positions: this.character.positions, normals: this.character.normals };
    }
    private inputValues(meshes: Mesh[]): number[] {
        return this.asset.inputNames.map((name) => {
            const own = this.inputs.get(name);
            if (own !== undefined) return own;
            for (const mesh of meshes) {
                const target = mesh.morphTargetDictionary?.[name];
                if (target !== undefined) return mesh.morphTargetInfluences?.[target] ?? 0;
            }
            return 0;
        });
    }

    /** What each vertex loses of each colour, and E. */
    private computeLoss(): void {
        const { loss, open, visible } = this;
        const e = this.character.ambient();
        const count = this.asset.vertexCount;
        if (!this.environment) {
            for (let v = 0; v < count; ++v) {
                const lost = this.strength * (1 - e[v]);
                loss[4 * v] = loss[4 * v + 1] = loss[4 * v + 2] = lost;
                loss[4 * v + 3] = 1 - lost;
            }
            return;
        }
        const light = this.environment.inFrameOf(this.root.matrixWorld);
        openIrradiance(light, this.character.normals, open);
        visibleIrradiance(light, this.character.transfer(ORDER), visible);
        const ambient = this.character.ambient(); // the views from before are dead if memory grew
        for (let v = 0; v < count; ++v) {
            for (let k = 0; k < 3; ++k) {
                const share = open[3 * v + k] > 0 ? visible[3 * v + k] / open[3 * v + k] : 1;
                loss[4 * v + k] = this.strength * (1 - Math.min(Math.max(share, 0), 1));
            }
            loss[4 * v + 3] = 1 - this.strength * (1 - ambient[v]);
        }
    }
}
