import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Matrix4, type Bone, type Material, type Mesh, type Object3D } from 'three';
import { Character, type Asset, type Quality } from '../core.js';
import { PenumbraError } from '../error.js';
import { Loss, type LossLight } from '../loss.js';
import type { WorkerCharacter } from '../worker/client.js';
import type { CrowdMember } from '../worker/crowd.js';
import type { PenumbraEnvironment } from './environment.js';
import { matchVertices, type Match } from './match.js';
import { BY_VERTEX, patchMaterial } from './materials.js';

interface Part {
    mesh: Mesh;
    before: BufferGeometry;
    loss: BufferAttribute;
    vertices: Uint32Array;
}

function nameOf(object: Object3D): string {
    // three.js changes names for its animation paths
    return (object.userData.name as string | undefined) ?? object.name;
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
    /** Bands of the environment that count, 1 to 5 (default 5). */
    order?: number;
    /** Evaluates in a worker from now on, of the same asset as opened there. */
    worker?: WorkerCharacter;
}

/** Soft self-shadows of an object that the asset was baked from. Its materials stay its own: the light of the
 * environment on them is darkened, in colour, where the character hides it from itself. */
export class PenumbraCharacter {
    /** Disposed of, where a worker evaluates. */
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
    private readonly loss: Float32Array;
    private readonly losses = new Loss();
    private readonly order: number | undefined;
    private readonly quality: Quality | undefined;
    private readonly worker: WorkerCharacter | undefined;
    private underWay: Promise<void> | undefined;
    private disposed = false;
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
        this.order = options.order;
        this.quality = options.quality;
        const meshes = options.meshes ?? meshesOf(root);
        this.character = new Character(asset);
        this.loss = new Float32Array(4 * asset.vertexCount);
        let match: Match;
        try {
            if (this.quality) this.character.setQuality(this.quality);
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
        this.undo = this.patch(meshes);
        this.worker = options.worker;
        if (this.worker) this.character.dispose();
    }

    setEnvironment(environment: PenumbraEnvironment | undefined): void {
        this.environment = environment;
    }

    /**
     * Computes the shadows of the pose that the bones have now: once a frame, after the mixer. A worker answers later;
     * the promise tells when the shadows are there. A pose that comes before the answer to the last one is passed over.
     */
    update(): Promise<void> | void {
        if (this.worker) return (this.underWay ??= this.updateBy(this.worker).finally(() => (this.underWay = undefined)));
        this.root.updateMatrixWorld(true);
        this.pose(this.parts.map((part) => part.mesh));
        this.character.evaluate();
        this.losses.compute(this.character, this.light(), this.loss);
        this.apply(this.loss);
    }

    /** Shows losses of the asset's vertices that the caller has, [V, 4]: what each colour loses, and E. */
    apply(losses: Float32Array): void {
        if (this.disposed) return;
        for (const { loss, vertices } of this.parts) {
            const out = loss.array as Float32Array;
            for (let i = 0; i < vertices.length; ++i)
                for (let k = 0; k < 4; ++k) out[4 * i + k] = losses[4 * vertices[i] + k];
            loss.needsUpdate = true;
        }
    }

    /**
     * Returns the member that a Crowd updates in its worker: `distance` tells how far the character is from the viewer.
     */
    member(distance: () => number): CrowdMember {
        const character = this.worker;
        if (!character) throw new PenumbraError('INVALID_ARGUMENT', "a member of a crowd needs the option 'worker'");
        return {
            character,
            distance,
            writePose: (matrices) => this.writePose(matrices),
            inputs: () => this.inputValues(),
            light: () => {
                this.root.updateMatrixWorld(true); // writePose comes next, and needs them as well
                return this.light();
            },
            apply: (loss) => this.apply(loss),
        };
    }

    /** Where the character's first bone is, in the world. */
    get bodyWorld(): Matrix4 {
        return this.bones[0].matrixWorld;
    }

    /**
     * Gives memory back, and the meshes their geometries and materials; the worker's character is disposed of, too.
     * Take a member out of its crowd first. A second call does nothing.
     */
    dispose(): void {
        if (this.disposed) return;
        this.disposed = true;
        for (const undo of this.undo) undo();
        for (const { mesh, before } of this.parts) {
            mesh.geometry.dispose();
            mesh.geometry = before;
        }
        this.character.dispose();
        this.worker?.dispose();
    }

    /** Makes the meshes' materials use the attribute `penumbraLoss`. Answers what undoes it. */
    protected patch(meshes: Mesh[]): (() => void)[] {
        const materials = new Set<Material>(meshes.flatMap((mesh) => mesh.material));
        return [...materials].map((material) => patchMaterial(material, BY_VERTEX));
    }

    private async updateBy(worker: WorkerCharacter): Promise<void> {
        if (this.disposed) throw new PenumbraError('DISPOSED', 'this object was disposed of');
        this.root.updateMatrixWorld(true);
        try {
            const how = { ...this.light(), quality: this.quality };
            this.apply(await worker.update((matrices) => this.writePose(matrices), this.inputValues(), how));
        } catch (error) {
            if (!this.disposed) throw error; // nobody waits for it any more
        }
    }
    private pose(meshes: Mesh[]): void {
        if (this.asset.inputCount > 0) this.character.setInputs(this.inputValues(meshes));
        this.writePose(this.character.poseMatrices);
        this.character.setPose();
    }
    private writePose(matrices: Float32Array): void {
        this.toModel.copy(this.root.matrixWorld).invert();
        this.bones.forEach((bone, j) => {
            this.scratch.multiplyMatrices(this.toModel, bone.matrixWorld).multiply(this.inverseBind[j]);
            this.scratch.toArray(matrices, 16 * j);
        });
    }
    private skinned(meshes: Mesh[]): { positions: Float32Array; normals: Float32Array } {
        this.pose(meshes);
        this.character.skin();
        return { positions: this.character.positions, normals: this.character.normals };
    }
    private inputValues(meshes: Mesh[] = this.parts.map((part) => part.mesh)): number[] {
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

    private light(): LossLight {
        return { sh: this.environment?.inFrameOf(this.root.matrixWorld), strength: this.strength, order: this.order };
    }
}
