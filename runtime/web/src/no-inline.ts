import { createRuntime, type Runtime } from './core.js';

export * from './shared.js';

/** Makes an instance from the file penumbra.wasm: its URL, its bytes, or what WebAssembly.compile made of them. */
export async function load(source: string | URL | BufferSource | WebAssembly.Module): Promise<Runtime> {
    if (typeof source !== 'string' && !(source instanceof URL)) return createRuntime(source);
    const response = await fetch(source);
    if (!response.ok) throw new Error(`${source}: ${response.status} ${response.statusText}`);
    return createRuntime(await response.arrayBuffer());
}
