import type { Asset } from 'penumbra-player';
import { openIrradiance, visibleIrradiance } from 'penumbra-player/sh';
import { bytesOf } from './load';

interface About {
    clip: string;
    times: number[];
    vertices: number;
    order: number;
    scales: number[];
}

/** Ray-traced transfer of one clip, as scripts/figures/web_truth.py packs it. */
export class Truth {
    readonly clip: string;
    readonly order: number;
    /** [16, vertices, F] */
    private readonly numbers: Int8Array;
    private readonly transfer: Float32Array;
    private readonly open: Float32Array;
    private readonly visible: Float32Array;
    private readonly source: Uint32Array;

    private constructor(
        private readonly about: About,
        bytes: Int8Array,
        asset: Asset,
    ) {
        this.clip = about.clip;
        this.order = about.order;
        const frames = about.times.length;
        this.numbers = new Int8Array(bytes);
        for (let i = 0; i < this.numbers.length; ++i) if (i % frames !== 0) this.numbers[i] += this.numbers[i - 1];
        this.transfer = new Float32Array(about.order ** 2 * asset.vertexCount);
        this.open = new Float32Array(3 * asset.vertexCount);
        this.visible = new Float32Array(3 * asset.vertexCount);
        this.source = asset.sourceVertices;
    }

    static async load(name: string, asset: Asset): Promise<Truth> {
        const bytes = await bytesOf(name);
        const length = new DataView(bytes).getUint32(0, true);
        const about = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length))) as About;
        if (about.vertices !== asset.sourceVertexCount) throw new Error(`${name} is of another character`);
        return new Truth(about, new Int8Array(bytes, 4 + length), asset);
    }

    /** Writes what each vertex loses at a time of the clip, as PenumbraCharacter.apply wants it. */
    loss(seconds: number, normals: Float32Array, sh: Float32Array | undefined, out: Float32Array): void {
        this.interpolate(seconds);
        const { transfer, open, visible, order } = this;
        const count = order * order;
        if (sh) {
            openIrradiance(sh, normals, open, order);
            visibleIrradiance(sh, transfer, visible, order);
        }
        for (let v = 0; v < normals.length / 3; ++v) {
            const ambient = Math.min(Math.max(transfer[count * v] * AMBIENT, 0), 1);
            for (let k = 0; k < 3; ++k) {
                const share = !sh ? ambient : open[3 * v + k] > 0 ? visible[3 * v + k] / open[3 * v + k] : 1;
                out[4 * v + k] = 1 - Math.min(Math.max(share, 0), 1);
            }
            out[4 * v + 3] = ambient;
        }
    }

    private interpolate(seconds: number): void {
        const { times, vertices, scales } = this.about;
        const frames = times.length;
        const last = times[frames - 1];
        const wrapped = seconds - Math.floor(seconds / last) * last;
        let frame = 0;
        while (frame + 2 < frames && times[frame + 1] <= wrapped) ++frame;
        const weight = Math.min(Math.max((wrapped - times[frame]) / (times[frame + 1] - times[frame]), 0), 1);
        const count = scales.length;
        for (let i = 0; i < count; ++i)
            for (let s = 0; s < vertices; ++s) {
                const at = (i * vertices + s) * frames + frame;
                const value = this.numbers[at] * (1 - weight) + this.numbers[at + 1] * weight;
                this.transfer[count * this.source[s] + i] = scales[i] * value;
            }
    }
}

const AMBIENT = Math.sqrt(4 * Math.PI) / Math.PI; // E of the first coefficient
