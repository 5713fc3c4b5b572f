import { PenumbraError } from './error.js';
import { instantiate } from './instantiate.js';
import { Arrays, Memory } from './memory.js';

const NONE = -1; // PENUMBRA_NONE
const COLUMNS_4X4 = 1; // PENUMBRA_COLUMNS_4X4
// Offsets in penumbra_asset_info and the other structs: structs.cpp holds these to the C header.
const INFO_SIZE = 136;
const VERTICES_SIZE = 32;

export type Quality = 'full' | 'fast';
/** Rows [R | t] of a rotation and a translation, 12 numbers. */
export type Place = ArrayLike<number>;

/** An object with a handle of the C library, which it gives back once. */
abstract class Handle {
    protected constructor(
        readonly runtime: Runtime,
        private at: number,
        private readonly destroy: string,
    ) {}

    /** @internal */
    get handle(): number {
        if (this.at === 0) throw new PenumbraError('DISPOSED', 'this object was disposed of');
        return this.at;
    }
    get disposed(): boolean {
        return this.at === 0;
    }
    /** Gives the memory back. A second call does nothing. */
    dispose(): void {
        if (this.at === 0) return;
        this.runtime.memory.call(this.destroy, this.at);
        this.at = 0;
        this.release();
    }
    protected release(): void {}
}

/** One instance of the module. All that is made of it lives in its memory. */
export class Runtime {
    /** @internal */
    constructor(readonly memory: Memory) {}

    get version(): string {
        return this.memory.text(this.memory.call('penumbra_version'));
    }
    /** Bytes that the module holds. They grow, and never shrink. */
    get memoryBytes(): number {
        return this.memory.size;
    }
    /** Opens the bytes of a .pnb file. Throws INVALID_ASSET for any others. */
    open(bytes: ArrayBuffer | ArrayBufferView): Asset {
        return new Asset(this, bytes);
    }
}

/** Makes an instance from the bytes of penumbra.wasm, or from what WebAssembly.compile made of them. */
export async function createRuntime(source: BufferSource | WebAssembly.Module): Promise<Runtime> {
    return new Runtime(await instantiate(source));
}

export interface Clip {
    name: string;
    firstFrame: number;
    frameCount: number;
    heldOut: boolean;
}
export interface Light {
    name: string;
    order: number;
    /** [order^2, 3], real and orthonormal with the Condon-Shortley sign, in the model frame. */
    sh: Float32Array;
    sunCount: number;
}

/** @internal */
export interface Cluster {
    firstVertex: number;
    vertexCount: number;
    componentCount: number;
    /** Where its scores are among those of all clusters. */
    firstScore: number;
    /** 0: f32, 1: f16, 2: bytes (penumbra_precision). */
    meanPrecision: number;
    basisPrecision: number;
    /** [vertexCount, stride] */
    mean: Uint32Array;
    /** [componentCount, vertexCount, stride] */
    basis: Uint32Array;
    scale: Float32Array;
}
const BYTES_OF_PRECISION = [4, 2, 1];

const COPY = 1; // PENUMBRA_COPY: what is made of an asset may outlive it

function openBytes(memory: Memory, bytes: ArrayBuffer | ArrayBufferView): number {
    const source = ArrayBuffer.isView(bytes)
        ? new Uint8Array(bytes.buffer, bytes.byteOffset, bytes.byteLength)
        : new Uint8Array(bytes);
    const at = memory.allocate(source.length);
    try {
        memory.bytes(at, source.length).set(source);
        memory.check('penumbra_asset_open_memory', at, source.length, COPY, memory.out);
    } finally {
        memory.free(at);
    }
    return memory.word(memory.out);
}

/** A checked .pnb file. */
export class Asset extends Handle {
    readonly hasModel: boolean;
    readonly vertexCount: number;
    readonly sourceVertexCount: number;
    readonly triangleCount: number;
    readonly deforming: boolean;
    readonly inputCount: number;
    readonly morphCount: number;
    readonly rotationCount: number;
    readonly convention: string;
    /** Numbers a vertex in arrays of coefficients. */
    readonly stride: number;
    readonly clusterCount: number;
    readonly followerCount: number;
    readonly provenance: string;
    readonly jointNames: readonly string[];
    readonly inputNames: readonly string[];
    readonly clips: readonly Clip[];
    readonly frameCount: number;
    readonly materialCount: number;
    readonly lightCount: number;
    readonly casts: boolean;
    private readonly info: Uint32Array;

    /** @internal */
    constructor(runtime: Runtime, bytes: ArrayBuffer | ArrayBufferView) {
        const { memory } = runtime;
        const handle = openBytes(memory, bytes);
        super(runtime, handle, 'penumbra_asset_close');
        memory.call('penumbra_asset_get_info', handle, memory.out);
        const info = memory.words(memory.out, INFO_SIZE / 4).slice();
        this.info = info;
        this.hasModel = info[0] !== 0;
        this.provenance = memory.text(info[1]);
        this.vertexCount = info[2];
        this.sourceVertexCount = info[3];
        this.triangleCount = info[4];
        this.deforming = info[15] !== 0;
        this.inputCount = info[18];
        this.frameCount = info[24];
        this.rotationCount = info[25];
        this.convention = memory.text(info[26]);
        this.stride = info[28];
        this.clusterCount = info[29];
        this.materialCount = info[32];
        this.lightCount = info[33];
        this.morphCount = memory.call('penumbra_asset_morph_count', handle, 0);
        const names = (count: number, name: string) =>
            Array.from({ length: count }, (_, i) => memory.text(memory.call(name, handle, i)));
        this.jointNames = names(info[19], 'penumbra_asset_joint_name');
        this.inputNames = names(info[18], 'penumbra_asset_input_name');
        this.clips = Array.from({ length: info[23] }, (_, i) => this.clip(i));
        memory.call('penumbra_asset_get_followers', handle, memory.out);
        this.followerCount = memory.word(memory.out + 4);
        this.casts =
            memory.call('penumbra_asset_part_count', handle) > 0 || memory.call('penumbra_asset_sphere_count', handle) > 0;
    }

    /** [sourceVertexCount] the asset's vertex of each vertex of the source. A copy, like the others. */
    get sourceVertices(): Uint32Array {
        return this.copy(this.info[9], this.sourceVertexCount, Uint32Array);
    }
    /** [triangleCount, 3] */
    get triangles(): Uint32Array {
        return this.copy(this.info[8], 3 * this.triangleCount, Uint32Array);
    }
    /** [vertexCount, 3] */
    get restPositions(): Float32Array {
        return this.copy(this.info[5], 3 * this.vertexCount, Float32Array);
    }
    /** [J, 3, 4] rows, rest positions to joint; empty where the asset has none. */
    get inverseBind(): Float32Array {
        return this.copy(this.info[22], this.info[22] ? 12 * this.jointNames.length : 0, Float32Array);
    }
    light(index: number): Light {
        const { memory } = this.runtime;
        if (!(index >= 0 && index < this.lightCount))
            throw new PenumbraError('INVALID_ARGUMENT', `light ${index} of ${this.lightCount}`);
        memory.call('penumbra_asset_get_light', this.handle, index, memory.out);
        const [name, order, sh, , sunCount] = memory.words(memory.out, 5).slice();
        return { name: memory.text(name), order, sh: memory.floats(sh, 3 * order * order).slice(), sunCount };
    }

    /**
     * @internal Whether the numbers are a mean and components alone, without fields of parts, followers or transfer.
     */
    get isAdditive(): boolean {
        const parts = this.runtime.memory.call('penumbra_asset_part_count', this.handle);
        return this.hasModel && parts === 0 && this.followerCount === 0 && !this.convention.startsWith('T');
    }
    /** @internal Scores of all clusters. */
    get scoreCount(): number {
        return this.info[30];
    }
    /** @internal What a GPU needs of a cluster: words of the file, and 1 or the scale for each component. */
    cluster(index: number): Cluster {
        const { memory } = this.runtime;
        memory.call('penumbra_asset_get_cluster', this.handle, index, memory.out);
        const [, firstVertex, vertexCount, componentCount, firstScore, meanPrecision, basisPrecision, mean, basis, scale] =
            memory.words(memory.out, 10).slice();
        const wordsOf = (at: number, numbers: number, precision: number) =>
            memory.words(at, (numbers * BYTES_OF_PRECISION[precision]) / 4).slice();
        const numbers = vertexCount * this.stride;
        return {
            firstVertex, vertexCount, componentCount, firstScore, meanPrecision, basisPrecision,
            mean: wordsOf(mean, numbers, meanPrecision),
            basis: wordsOf(basis, componentCount * numbers, basisPrecision),
            scale: scale ? memory.floats(scale, componentCount).slice() : new Float32Array(componentCount).fill(1),
        };
    }

    private clip(index: number): Clip {
        const { memory } = this.runtime;
        memory.call('penumbra_asset_get_clip', this.handle, index, memory.out);
        const [name, firstFrame, frameCount, heldOut] = memory.words(memory.out, 4).slice();
        return { name: memory.text(name), firstFrame, frameCount, heldOut: heldOut !== 0 };
    }
    private copy<T extends Uint32Array | Float32Array>(
        at: number,
        count: number,
        type: { new (buffer: ArrayBufferLike, offset: number, count: number): T },
    ): T {
        void this.handle;
        return new type(this.runtime.memory.bytes(at, 4 * count).slice().buffer, 0, count);
    }
}

/** One pose of an asset's model. Results stay valid until the next call of any object of this runtime. */
export class Character extends Handle {
    private readonly arrays: Arrays;
    private readonly matrices: number;
    private readonly vertices: number;
    private readonly ambientAt: number;
    private readonly transferAt: number;
    private readonly inputsAt: number;

    constructor(readonly asset: Asset) {
        const { memory } = asset.runtime;
        memory.check('penumbra_character_create', asset.handle, memory.out);
        super(asset.runtime, memory.word(memory.out), 'penumbra_character_destroy');
        const count = asset.vertexCount;
        this.arrays = new Arrays(memory);
        this.matrices = this.arrays.floats(16 * asset.jointNames.length);
        this.inputsAt = this.arrays.floats(Math.max(asset.inputCount, 3 * asset.sourceVertexCount));
        this.vertices = this.arrays.floats(VERTICES_SIZE / 4);
        const perVertex = [3, 3, 3, asset.stride].map((size) => this.arrays.floats(size * count));
        this.ambientAt = this.arrays.floats(count);
        this.transferAt = this.arrays.floats(Math.max(25 * count, asset.scoreCount));
        memory.words(this.vertices, VERTICES_SIZE / 4).set([...perVertex, 0, 0, count, 0]);
    }

    setQuality(quality: Quality): void {
        this.runtime.memory.check('penumbra_character_set_quality', this.handle, quality === 'fast' ? 1 : 0);
    }
    /** Poses by a sampled frame of the asset. */
    setFrame(frame: number): void {
        this.runtime.memory.check('penumbra_character_set_frame', this.handle, frame);
    }
    /** Room for J matrices of 4 x 4 columns, joint in the model frame times inverse bind, which setPose reads. */
    get poseMatrices(): Float32Array {
        return this.runtime.memory.floats(this.matrices, 16 * this.asset.jointNames.length);
    }
    /** Writes the matrices of the joints that stand for inputs (weights of morph targets and others). */
    setInputs(inputs: ArrayLike<number>): void {
        const { memory } = this.runtime;
        this.requireCount('inputs', inputs.length, this.asset.inputCount);
        memory.floats(this.inputsAt, inputs.length).set(inputs);
        memory.check(
            'penumbra_asset_input_matrices', this.asset.handle, COLUMNS_4X4,
            this.inputsAt, inputs.length, this.matrices, this.asset.jointNames.length,
        );
    }
    /** Poses by poseMatrices, or by `matrices`, which it copies there. */
    setPose(matrices?: ArrayLike<number>): void {
        const { memory } = this.runtime;
        const joints = this.asset.jointNames.length;
        if (matrices) {
            this.requireCount('matrices', matrices.length, 16 * joints);
            this.poseMatrices.set(matrices);
        }
        memory.check('penumbra_character_set_pose', this.handle, COLUMNS_4X4, this.matrices, joints, 0, 0);
    }
    /** Poses a deforming mesh by the positions of its source vertices, [sourceVertexCount, 3] in the model frame. */
    setPositions(positions: ArrayLike<number>): void {
        const { memory } = this.runtime;
        this.requireCount('positions', positions.length, 3 * this.asset.sourceVertexCount);
        memory.floats(this.inputsAt, positions.length).set(positions);
        memory.check('penumbra_character_set_positions', this.handle, 0, this.inputsAt, this.asset.sourceVertexCount, 0, 0);
    }
    /** Computes coefficients, positions, normals and tangents of the pose. */
    evaluate(): void {
        const { memory } = this.runtime;
        memory.check('penumbra_character_evaluate', this.handle, 0, this.asset.clusterCount, this.vertices);
        memory.check('penumbra_character_skin', this.handle, this.vertices);
        if (this.asset.followerCount > 0) memory.check('penumbra_character_follow', this.handle, this.vertices);
    }
    /** Computes positions, normals and tangents alone. */
    skin(): void {
        this.runtime.memory.check('penumbra_character_skin', this.handle, this.vertices);
    }

    get positions(): Float32Array {
        return this.vertexArray(0, 3);
    }
    get normals(): Float32Array {
        return this.vertexArray(1, 3);
    }
    get coefficients(): Float32Array {
        return this.vertexArray(3, this.asset.stride);
    }
    /** Visibility of each vertex from 0 to 1, weighted by the cosine. */
    ambient(): Float32Array {
        const { memory } = this.runtime;
        memory.check('penumbra_character_ambient', this.handle, this.vertices, this.ambientAt);
        return memory.floats(this.ambientAt, this.asset.vertexCount);
    }
    /** [vertexCount, order^2] whose product with the SH of a light is the irradiance; order 1 to 5. */
    transfer(order: number): Float32Array {
        const { memory } = this.runtime;
        memory.check('penumbra_character_transfer', this.handle, order, this.vertices, this.transferAt);
        return memory.floats(this.transferAt, order * order * this.asset.vertexCount);
    }
    /** @internal Scores of all clusters for the pose. */
    get scores(): Float32Array {
        const { memory } = this.runtime;
        memory.call('penumbra_character_get_scores', this.handle, this.transferAt, 0);
        return memory.floats(this.transferAt, this.asset.scoreCount);
    }
    /** @internal Weights of the coefficients in E, [stride]. */
    get ambientWeights(): Float32Array {
        const { stride } = this.asset;
        return Float32Array.from({ length: stride }, (_, i) => {
            this.coefficients.fill(0, 0, stride)[i] = 1;
            return this.ambient()[0];
        });
    }
    /** How far the pose is from those that the model knows, in about radians. */
    get outOfRange(): number {
        return this.runtime.memory.call('penumbra_character_out_of_range', this.handle);
    }

    /** @internal The penumbra_vertices of all vertices. */
    get vertexArrays(): number {
        return this.vertices;
    }
    private vertexArray(index: number, size: number): Float32Array {
        const { memory } = this.runtime;
        void this.handle;
        return memory.floats(memory.word(this.vertices + 4 * index), size * this.asset.vertexCount);
    }
    private requireCount(what: string, count: number, expected: number): void {
        if (count !== expected) throw new PenumbraError('INVALID_ARGUMENT', `${count} numbers of ${what}, not ${expected}`);
    }
    protected override release(): void {
        this.arrays.free();
    }
}

const MOST_LIGHT_ORDER = 8;

/** The asset's own materials under a light: for pictures without another renderer. */
export class Shading extends Handle {
    private readonly arrays: Arrays;
    private readonly numbers: number;
    private readonly radiance: number;
    private readonly vertexCount: number;

    constructor(asset: Asset, options: { callerLightOrder?: number } = {}) {
        const { memory } = asset.runtime;
        memory.words(memory.out, 3).set([0, 0, options.callerLightOrder ?? 0]);
        const out = memory.out + 16;
        memory.check('penumbra_shading_create', asset.handle, 0, 0, memory.out, out);
        super(asset.runtime, memory.word(out), 'penumbra_shading_destroy');
        this.vertexCount = asset.vertexCount;
        this.arrays = new Arrays(memory);
        this.numbers = this.arrays.floats(3 * MOST_LIGHT_ORDER ** 2);
        this.radiance = this.arrays.floats(3 * asset.vertexCount);
    }

    setLight(light: number): void {
        this.runtime.memory.check('penumbra_shading_set_light', this.handle, light);
    }
    /** Switches a light of the caller on, [order^2, 3]. */
    setShLight(order: number, sh: ArrayLike<number>): void {
        const { memory } = this.runtime;
        if (!(order >= 1 && order <= MOST_LIGHT_ORDER) || sh.length !== 3 * order * order)
            throw new PenumbraError('INVALID_ARGUMENT', `${sh.length} numbers are no light of order ${order}`);
        memory.floats(this.numbers, sh.length).set(sh);
        memory.check('penumbra_shading_set_sh_light', this.handle, order, this.numbers, 0);
    }
    /** Turns the light by the rows of a rotation, 9 numbers. */
    setLightRotation(rotation: ArrayLike<number>): void {
        this.runtime.memory.floats(this.numbers, 9).set(rotation);
        this.runtime.memory.check('penumbra_shading_set_light_rotation', this.handle, this.numbers);
    }
    /** Radiance towards `eye` in the model frame, [vertexCount, 3], linear Rec.709. */
    shade(character: Character, eye: ArrayLike<number>): Float32Array {
        const { memory } = this.runtime;
        if (character.asset.vertexCount !== this.vertexCount)
            throw new PenumbraError('INVALID_ARGUMENT', 'the character is of another asset');
        void character.handle;
        memory.floats(this.numbers, 3).set(eye);
        memory.check('penumbra_shading_shade', this.handle, this.numbers, character.vertexArrays, this.radiance);
        return memory.floats(this.radiance, 3 * this.vertexCount);
    }
    protected override release(): void {
        this.arrays.free();
    }
}

/** Points of other meshes that casters darken. Neighbours should follow one another. */
export class ScenePoints {
    private readonly arrays: Arrays;
    private readonly struct: number;
    private readonly results: number;
    private readonly light: number;

    /** `positions` and unit `normals` are [count, 3], in the scene. */
    constructor(
        private readonly runtime: Runtime,
        positions: ArrayLike<number>,
        normals: ArrayLike<number>,
    ) {
        const { memory } = runtime;
        this.count = positions.length / 3;
        if (normals.length !== positions.length || !Number.isInteger(this.count))
            throw new PenumbraError('INVALID_ARGUMENT', `${positions.length} numbers of positions, ${normals.length} of normals`);
        this.arrays = new Arrays(memory);
        const at = [positions, normals].map((values) => {
            const array = this.arrays.floats(values.length);
            memory.floats(array, values.length).set(values);
            return array;
        });
        this.struct = this.arrays.floats(3);
        memory.words(this.struct, 3).set([...at, this.count]);
        this.results = this.arrays.floats(3 * this.count);
        this.light = this.arrays.floats(75);
    }
    readonly count: number;

    /** Moves the points. */
    move(positions: ArrayLike<number>): void {
        if (positions.length !== 3 * this.count)
            throw new PenumbraError('INVALID_ARGUMENT', `${positions.length} numbers of positions, not ${3 * this.count}`);
        const { memory } = this.runtime;
        memory.floats(memory.word(this.struct), positions.length).set(positions);
    }
    /** Visibility of each point from 0 to 1, weighted by the cosine. `except` is a caster that does not count. */
    ambient(scene: Scene, except: number = NONE): Float32Array {
        const { memory } = this.runtime;
        memory.check('penumbra_scene_ambient', scene.handle, except, this.struct, this.results);
        return memory.floats(this.results, this.count);
    }
    /** Irradiance [count, 3] of a light `sh` [order^2, 3], order 1 to 5. */
    irradiance(scene: Scene, order: number, sh: ArrayLike<number>, except: number = NONE): Float32Array {
        const { memory } = this.runtime;
        if (!(order >= 1 && order <= 5) || sh.length !== 3 * order * order)
            throw new PenumbraError('INVALID_ARGUMENT', `${sh.length} numbers are no light of order ${order}`);
        memory.floats(this.light, sh.length).set(sh);
        memory.check('penumbra_scene_irradiance', scene.handle, except, this.struct, order, this.light, this.results);
        return memory.floats(this.results, 3 * this.count);
    }
    dispose(): void {
        this.arrays.free();
    }
}

/** Characters that cast on one another and on other meshes. */
export class Scene extends Handle {
    private readonly arrays: Arrays;
    private readonly place: number;

    constructor(runtime: Runtime, assets: readonly Asset[]) {
        const { memory } = runtime;
        const arrays = new Arrays(memory);
        const list = arrays.floats(assets.length);
        memory.words(list, assets.length).set(assets.map((asset) => asset.handle));
        try {
            memory.check('penumbra_scene_create', list, assets.length, memory.out);
        } catch (error) {
            arrays.free();
            throw error;
        }
        super(runtime, memory.word(memory.out), 'penumbra_scene_destroy');
        this.arrays = arrays;
        this.place = arrays.floats(12);
    }
    /** Takes over a character's pose, and where it stands; null hides nothing from now on. */
    setCaster(caster: number, character: Character | null, toScene?: Place): void {
        this.runtime.memory.check(
            'penumbra_scene_set_caster', this.handle, caster, character ? character.handle : 0, this.placed(toScene),
        );
    }
    /** Darkens a character that was evaluated, where it stands, by all casters but `except`. */
    cast(character: Character, except: number = NONE, toScene?: Place): void {
        this.runtime.memory.check(
            'penumbra_scene_cast', this.handle, except, character.handle, this.placed(toScene), character.vertexArrays,
        );
    }
    private placed(toScene?: Place): number {
        if (!toScene) return 0;
        this.runtime.memory.floats(this.place, 12).set(toScene);
        return this.place;
    }
    protected override release(): void {
        this.arrays.free();
    }
}
