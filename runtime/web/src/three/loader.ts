import type { GLTF, GLTFLoaderPlugin, GLTFParser } from 'three/addons/loaders/GLTFLoader.js';
import type { Asset, Runtime } from '../core.js';

const EXTENSION = 'PENUMBRA_visibility';

/** A plugin of GLTFLoader: `loader.register((parser) => new PenumbraLoader(parser, load()))`. It puts the asset that
 * `penumbra-pack embed` put into a .glb at `gltf.userData.penumbra`, and its bytes, which a worker opens, at
 * `gltf.userData.penumbraBytes`. Files without one load as ever. */
export class PenumbraLoader implements GLTFLoaderPlugin {
    readonly name = EXTENSION;

    constructor(
        private readonly parser: GLTFParser,
        private readonly runtime: Runtime | Promise<Runtime>,
    ) {}

    async afterRoot(gltf: GLTF): Promise<void> {
        const extension = this.parser.json.extensions?.[EXTENSION] as { bufferView: number } | undefined;
        if (!extension) return;
        const bytes = (await this.parser.getDependency('bufferView', extension.bufferView)) as ArrayBuffer;
        gltf.userData.penumbraBytes = bytes;
        gltf.userData.penumbra = (await this.runtime).open(bytes);
    }
}

/** The asset of a file that PenumbraLoader loaded, or undefined. */
export function assetOf(gltf: GLTF): Asset | undefined {
    return gltf.userData.penumbra as Asset | undefined;
}
