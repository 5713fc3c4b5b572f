/// <reference types="@webgpu/types" />
import { Character, type Asset, type Cluster } from '../core.js';
import { PenumbraError } from '../error.js';
import { farWgsl } from './far.js';

const GROUP = 64;
const CLUSTER_WORDS = 8;

interface Places {
    stride: number;
    /** Words of the tables of clusters, of the cluster of each vertex, and of the weights in E. */
    clusters: number;
    clusterOfVertex: number;
    weights: number;
    vertexCount: number;
    clusterCount: number;
    hasResidual: boolean;
    isComposed: boolean;
}

// Coefficients = mean + sum over k of score_k scale_k basis_k, then the shortest way to where E lies in [0, 1]
// (runtime/penumbra.h, penumbra_cluster; clampAmbient of sh/visibility_convention.h). Scores come with their scales.
const shader = (places: Places) => `
const STRIDE4 = ${places.stride / 4}u;
const CLUSTERS = ${places.clusters}u;
const CLUSTER_OF_VERTEX = ${places.clusterOfVertex}u;
const WEIGHTS = ${places.weights}u;
@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<storage, read> pose: array<f32>;  // scores come first
@group(0) @binding(2) var<storage, read_write> coefficients: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> ambient: array<f32>;
${places.isComposed ? '@group(0) @binding(4) var<storage, read_write> anchor_values: array<vec4f>;' : ''}

// Four numbers of an array that begins at a word; precision as penumbra_precision.
fn numbers(first: u32, index: u32, format: u32) -> vec4f {
    if (format == 2u) {
        let word = bitcast<i32>(words[first + index]);
        return vec4f(f32(extractBits(word, 0u, 8u)), f32(extractBits(word, 8u, 8u)),
                     f32(extractBits(word, 16u, 8u)), f32(extractBits(word, 24u, 8u)));
    }
    if (format == 1u) {
        return vec4f(unpack2x16float(words[first + 2u * index]), unpack2x16float(words[first + 2u * index + 1u]));
    }
    let at = first + 4u * index;
    return vec4f(bitcast<f32>(words[at]), bitcast<f32>(words[at + 1u]), bitcast<f32>(words[at + 2u]), bitcast<f32>(words[at + 3u]));
}
fn weight(q: u32) -> vec4f { return numbers(WEIGHTS, q, 0u); }

// Adds the mean and the components of a cluster, whose row of the table this is.
fn add_model(row: u32, vertex_of_all: u32, sums: ptr<function, array<vec4f, STRIDE4>>) {
    let at = CLUSTERS + ${CLUSTER_WORDS}u * row;
    let vertex = vertex_of_all - words[at];
    for (var q = 0u; q < STRIDE4; q++) { (*sums)[q] += numbers(words[at + 4u], vertex * STRIDE4 + q, words[at + 6u]); }
    for (var k = 0u; k < words[at + 2u]; k++) {
        let score = pose[words[at + 3u] + k];
        let first = (k * words[at + 1u] + vertex) * STRIDE4;
        for (var q = 0u; q < STRIDE4; q++) { (*sums)[q] += score * numbers(words[at + 5u], first + q, words[at + 7u]); }
    }
}

@compute @workgroup_size(${GROUP})
fn evaluate(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= ${places.vertexCount}u) { return; }
    let cluster = words[CLUSTER_OF_VERTEX + id.x];
    var sums: array<vec4f, STRIDE4>;
    add_model(cluster, id.x, &sums);
    ${places.isComposed ? 'compose(id.x, &sums);' : ''}
    ${places.hasResidual ? `add_model(cluster + ${places.clusterCount}u, id.x, &sums);` : ''}
    var e = 0.0;
    var norm2 = 0.0;
    for (var q = 0u; q < STRIDE4; q++) {
        e += dot(weight(q), sums[q]);
        norm2 += dot(weight(q), weight(q));
    }
    let excess = e - clamp(e, 0.0, 1.0);
    for (var q = 0u; q < STRIDE4; q++) { coefficients[id.x * STRIDE4 + q] = sums[q] - weight(q) * (excess / norm2); }
    ambient[id.x] = e - excess;
}`;

/** Arrays of words, one behind the other, each from a multiple of four words on. */
class Words {
    length = 0;
    private readonly arrays: { at: number; words: Uint32Array }[] = [];

    /** Where the array will stand. */
    place(words: Uint32Array): number {
        const at = this.length;
        this.arrays.push({ at, words });
        this.length = Math.ceil((at + words.length) / 4) * 4;
        return at;
    }
    get all(): Uint32Array {
        const all = new Uint32Array(Math.max(this.length, 4));
        for (const { at, words } of this.arrays) all.set(words, at);
        return all;
    }
}

/** The rows of the tables of clusters, whose scores begin at `firstScore`. Their numbers are placed among the words. */
function tableOf(clusters: readonly Cluster[], firstScore: number, words: Words): number[] {
    return clusters.flatMap((c) => [
        c.firstVertex, c.vertexCount, c.componentCount, firstScore + c.firstScore,
        words.place(c.mean), words.place(c.basis), c.meanPrecision, c.basisPrecision,
    ]);
}

/** Scales of the scores of some clusters, in the order of the scores. */
function scalesOf(clusters: readonly Cluster[]): Float32Array {
    const scales = new Float32Array(clusters.reduce((sum, c) => sum + c.componentCount, 0));
    for (const c of clusters) scales.set(c.scale, c.firstScore);
    return scales;
}

/** Evaluates a model on a GPU: coefficients and E of all vertices, in buffers of the device. Models are additive, or
 * composed without a floor; those whose vertices follow points are refused with UNSUPPORTED. */
export class GpuEvaluator {
    /** [vertexCount, stride], float32. */
    readonly coefficients: GPUBuffer;
    /** [vertexCount] visibility from 0 to 1, weighted by the cosine. */
    readonly ambient: GPUBuffer;
    private readonly pose: GPUBuffer;
    private readonly values: Float32Array;
    private readonly scales: Float32Array;
    private readonly residualScales: Float32Array;
    private readonly buffers: GPUBuffer[] = [];
    private readonly passes: { pipeline: GPUComputePipeline; group: GPUBindGroup; count: number }[];
    /** Where the fields begin among the words; undefined of an additive model. */
    private readonly fields: number | undefined;

    constructor(
        private readonly device: GPUDevice,
        private readonly asset: Asset,
    ) {
        const far = asset.isAdditive ? new Uint32Array(0) : asset.far();
        const isComposed = far.length > 0 && asset.followerCount === 0;
        if (!asset.isAdditive && !isComposed)
            throw new PenumbraError('UNSUPPORTED', 'a GPU evaluates additive and composed models without a floor, this one is of another kind');
        // 1. All that no pose changes.
        const clusters = asset.clusters;
        const residual = isComposed ? asset.residual : [];
        this.scales = scalesOf(clusters);
        this.residualScales = scalesOf(residual);
        const scoreCount = this.scales.length + this.residualScales.length;
        const words = new Words();
        const clusterOfVertex = new Uint32Array(asset.vertexCount);
        clusters.forEach((c, i) => clusterOfVertex.fill(i, c.firstVertex, c.firstVertex + c.vertexCount));
        const table = [...tableOf(clusters, 0, words), ...tableOf(residual, this.scales.length, words)];
        const places: Places = {
            stride: asset.stride,
            clusters: words.place(Uint32Array.from(table)),
            clusterOfVertex: words.place(clusterOfVertex),
            weights: words.place(new Uint32Array(weightsOf(asset).buffer)),
            vertexCount: asset.vertexCount,
            clusterCount: clusters.length,
            hasResidual: residual.length > 0,
            isComposed,
        };
        // 2. What a pose has: scores, posed parts, and the frames of vertices.
        const partCount = asset.partCount;
        const frames = scoreCount + (isComposed ? 28 * partCount : 0);
        this.values = new Float32Array(frames + (isComposed ? 9 * asset.vertexCount : 0));
        let code = shader(places);
        if (isComposed) {
            const first = words.place(far);
            this.fields = words.length;
            words.place(asset.fields(this.fields));
            code += farWgsl(asset.runtime.farGlsl, {
                far, first, partCount, parts: scoreCount, frames, vertexCount: asset.vertexCount, numbers: asset.coefficientCount,
            });
        }
        const all = words.all;
        this.buffer(all.byteLength, all);
        this.pose = this.buffer(this.values.byteLength, this.values);
        this.coefficients = this.buffer(4 * asset.stride * asset.vertexCount);
        this.ambient = this.buffer(4 * asset.vertexCount);
        if (isComposed) this.buffer(16 * far[1]);
        // 3. Anchors come before the vertices that take from them.
        const module = device.createShaderModule({ code });
        const counts = { ...(isComposed ? { anchors: far[0] } : {}), evaluate: asset.vertexCount };
        this.passes = Object.entries(counts).map(([entryPoint, count]) => this.pass(module, entryPoint, count));
    }

    /** Evaluates the pose that `character` has, at full quality. It needs no evaluate() of its own. */
    evaluate(character: Character): void {
        if (this.buffers.length === 0) throw new PenumbraError('DISPOSED', 'this object was disposed of');
        if (character.asset !== this.asset) throw new PenumbraError('INVALID_ARGUMENT', 'the character is of another asset');
        this.fill(character);
        this.device.queue.writeBuffer(this.pose, 0, this.values as Float32Array<ArrayBuffer>);
        const encoder = this.device.createCommandEncoder();
        for (const { pipeline, group, count } of this.passes) {
            const pass = encoder.beginComputePass();
            pass.setPipeline(pipeline);
            pass.setBindGroup(0, group);
            pass.dispatchWorkgroups(Math.ceil(count / GROUP));
            pass.end();
        }
        this.device.queue.submit([encoder.finish()]);
    }
    /** Gives the device's memory back. A second call does nothing. */
    dispose(): void {
        for (const buffer of this.buffers.splice(0)) buffer.destroy();
    }

    private fill(character: Character): void {
        const { values, scales, residualScales } = this;
        character.scores.forEach((score, i) => (values[i] = score * scales[i]));
        if (this.fields === undefined) return;
        let at = scales.length;
        if (residualScales.length > 0)
            character.residualScores(residualScales.length).forEach((score, i) => (values[at + i] = score * residualScales[i]));
        at += residualScales.length;
        const parts = character.parts(this.fields);
        values.set(parts, at);
        at += parts.length;
        character.skin();
        for (const array of [character.positions, character.normals, character.tangents]) {
            values.set(array, at);
            at += array.length;
        }
    }
    private pass(module: GPUShaderModule, entryPoint: string, count: number): { pipeline: GPUComputePipeline; group: GPUBindGroup; count: number } {
        // The layout is that of all entry points: one that is made for each would lack what that one does not read.
        const entries = this.buffers.map((_, binding) => {
            const type: GPUBufferBindingType = binding < 2 ? 'read-only-storage' : 'storage';
            return { binding, visibility: GPUShaderStage.COMPUTE, buffer: { type } };
        });
        const layout = this.device.createBindGroupLayout({ entries });
        const pipeline = this.device.createComputePipeline({
            layout: this.device.createPipelineLayout({ bindGroupLayouts: [layout] }),
            compute: { module, entryPoint },
        });
        const resources = this.buffers.map((buffer, binding) => ({ binding, resource: { buffer } }));
        return { pipeline, group: this.device.createBindGroup({ layout, entries: resources }), count };
    }
    private buffer(bytes: number, data?: Uint32Array | Float32Array): GPUBuffer {
        const usage = GPUBufferUsage.STORAGE | (data ? GPUBufferUsage.COPY_DST : GPUBufferUsage.COPY_SRC | GPUBufferUsage.VERTEX);
        const buffer = this.device.createBuffer({ size: Math.max(bytes, 16), usage });
        if (data) this.device.queue.writeBuffer(buffer, 0, data as Uint32Array<ArrayBuffer> | Float32Array<ArrayBuffer>);
        this.buffers.push(buffer);
        return buffer;
    }
}

function weightsOf(asset: Asset): Float32Array {
    const scratch = new Character(asset);
    try {
        return scratch.ambientWeights;
    } finally {
        scratch.dispose();
    }
}
