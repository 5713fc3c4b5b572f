/// <reference types="@webgpu/types" />
import { Character, type Asset, type Cluster } from '../core.js';
import { PenumbraError } from '../error.js';

const GROUP = 64;
const CLUSTER_WORDS = 8;

// Coefficients = mean + sum over k of score_k scale_k basis_k, then the shortest way to where E lies in [0, 1]
// (runtime/penumbra.h, penumbra_cluster; clampAmbient of sh/visibility_convention.h). Scores come with their scales.
const shader = (stride: number) => `
struct Cluster { first_vertex: u32, vertex_count: u32, component_count: u32, first_score: u32,
                 mean: u32, basis: u32, mean_precision: u32, basis_precision: u32 }
@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<storage, read> clusters: array<Cluster>;
@group(0) @binding(2) var<storage, read> cluster_of_vertex: array<u32>;
@group(0) @binding(3) var<storage, read> weights: array<vec4f, ${stride / 4}>;
@group(0) @binding(4) var<storage, read> scores: array<f32>;
@group(0) @binding(5) var<storage, read_write> coefficients: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> ambient: array<f32>;
const STRIDE4 = ${stride / 4}u;

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

@compute @workgroup_size(${GROUP})
fn evaluate(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&cluster_of_vertex)) { return; }
    let cluster = clusters[cluster_of_vertex[id.x]];
    let vertex = id.x - cluster.first_vertex;
    var sums: array<vec4f, STRIDE4>;
    for (var q = 0u; q < STRIDE4; q++) { sums[q] = numbers(cluster.mean, vertex * STRIDE4 + q, cluster.mean_precision); }
    for (var k = 0u; k < cluster.component_count; k++) {
        let score = scores[cluster.first_score + k];
        let row = (k * cluster.vertex_count + vertex) * STRIDE4;
        for (var q = 0u; q < STRIDE4; q++) { sums[q] += score * numbers(cluster.basis, row + q, cluster.basis_precision); }
    }
    var e = 0.0;
    var norm2 = 0.0;
    for (var q = 0u; q < STRIDE4; q++) {
        e += dot(weights[q], sums[q]);
        norm2 += dot(weights[q], weights[q]);
    }
    let excess = e - clamp(e, 0.0, 1.0);
    for (var q = 0u; q < STRIDE4; q++) { coefficients[id.x * STRIDE4 + q] = sums[q] - weights[q] * (excess / norm2); }
    ambient[id.x] = e - excess;
}`;

/** The words of all clusters in one array, and where each cluster's are. */
function packClusters(clusters: readonly Cluster[]): { words: Uint32Array; table: Uint32Array } {
    const words = new Uint32Array(clusters.reduce((sum, c) => sum + c.mean.length + c.basis.length, 0));
    const table = new Uint32Array(CLUSTER_WORDS * clusters.length);
    let at = 0;
    clusters.forEach((c, i) => {
        words.set(c.mean, at);
        words.set(c.basis, at + c.mean.length);
        const precisions = [c.meanPrecision, c.basisPrecision];
        table.set([c.firstVertex, c.vertexCount, c.componentCount, c.firstScore, at, at + c.mean.length, ...precisions], CLUSTER_WORDS * i);
        at += c.mean.length + c.basis.length;
    });
    return { words, table };
}

/**
 * Evaluates an additive model on a GPU: coefficients and E of all vertices, in buffers of the device. Composed models
 * and those whose vertices follow points are refused with UNSUPPORTED.
 */
export class GpuEvaluator {
    /** [vertexCount, stride], float32. */
    readonly coefficients: GPUBuffer;
    /** [vertexCount] visibility from 0 to 1, weighted by the cosine. */
    readonly ambient: GPUBuffer;
    private readonly scores: GPUBuffer;
    private readonly scales: Float32Array;
    private readonly buffers: GPUBuffer[] = [];
    private readonly pipeline: GPUComputePipeline;
    private readonly group: GPUBindGroup;

    constructor(
        private readonly device: GPUDevice,
        private readonly asset: Asset,
    ) {
        if (!asset.isAdditive) throw new PenumbraError('UNSUPPORTED', 'a GPU evaluates additive models alone, this one is of another kind');
        const clusters = Array.from({ length: asset.clusterCount }, (_, i) => asset.cluster(i));
        const clusterOfVertex = new Uint32Array(asset.vertexCount);
        this.scales = new Float32Array(asset.scoreCount);
        clusters.forEach((c, i) => {
            clusterOfVertex.fill(i, c.firstVertex, c.firstVertex + c.vertexCount);
            this.scales.set(c.scale, c.firstScore);
        });
        const { words, table } = packClusters(clusters);
        const inputs = [words, table, clusterOfVertex, weightsOf(asset), this.scales].map((data) => this.buffer(data.byteLength, data));
        this.scores = inputs[4];
        this.coefficients = this.buffer(4 * asset.stride * asset.vertexCount);
        this.ambient = this.buffer(4 * asset.vertexCount);
        const module = device.createShaderModule({ code: shader(asset.stride) });
        this.pipeline = device.createComputePipeline({ layout: 'auto', compute: { module, entryPoint: 'evaluate' } });
        const entries = this.buffers.map((buffer, binding) => ({ binding, resource: { buffer } }));
        this.group = device.createBindGroup({ layout: this.pipeline.getBindGroupLayout(0), entries });
    }

    /** Evaluates the pose that `character` has. It needs no evaluate() of its own. */
    evaluate(character: Character): void {
        if (this.buffers.length === 0) throw new PenumbraError('DISPOSED', 'this object was disposed of');
        if (character.asset !== this.asset) throw new PenumbraError('INVALID_ARGUMENT', 'the character is of another asset');
        const scores = Float32Array.from(character.scores, (score, i) => score * this.scales[i]);
        this.device.queue.writeBuffer(this.scores, 0, scores);
        const encoder = this.device.createCommandEncoder();
        const pass = encoder.beginComputePass();
        pass.setPipeline(this.pipeline);
        pass.setBindGroup(0, this.group);
        pass.dispatchWorkgroups(Math.ceil(this.asset.vertexCount / GROUP));
        pass.end();
        this.device.queue.submit([encoder.finish()]);
    }
    /** Gives the device's memory back. A second call does nothing. */
    dispose(): void {
        for (const buffer of this.buffers.splice(0)) buffer.destroy();
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
