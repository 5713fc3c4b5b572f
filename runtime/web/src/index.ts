import { createRuntime, type Runtime } from './core.js';
import { packed } from './packed.js';

export * from './shared.js';

let once: Promise<Runtime> | undefined;

/** The bytes of penumbra.wasm, which this file has inside. */
export async function unpack(): Promise<ArrayBuffer> {
    const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).arrayBuffer();
}

/** The instance that all callers share, made at the first call. A failure is not kept. */
export function load(): Promise<Runtime> {
    once ??= unpack().then(createRuntime);
    once.catch(() => (once = undefined));
    return once;
}
