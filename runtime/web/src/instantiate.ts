import { PenumbraError } from './error.js';
import { Memory } from './memory.js';

// One function whose body is `i8x16.splat` of a constant.
const SIMD = [0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11];

/** Tells whether this browser has the vectors of WebAssembly that the module is made of. */
export function hasSimd(): boolean {
    return typeof WebAssembly === 'object' && WebAssembly.validate(new Uint8Array(SIMD));
}

// The C library asks for these three alone, where it would print why it gives up. There is nowhere to print to.
const BAD_FILE = 8; // EBADF of WASI
const IMPORTS: WebAssembly.Imports = {
    wasi_snapshot_preview1: { fd_close: () => BAD_FILE, fd_seek: () => BAD_FILE, fd_write: () => BAD_FILE },
};

async function compile(source: BufferSource | WebAssembly.Module): Promise<WebAssembly.Module> {
    if (source instanceof WebAssembly.Module) return source;
    try {
        return await WebAssembly.compile(source);
    } catch (error) {
        if (/unsafe-eval|Content Security Policy|disallowed by embedder/i.test(String(error)))
            throw new PenumbraError(
                'BLOCKED_BY_CSP',
                "the page's Content-Security-Policy forbids WebAssembly: add 'wasm-unsafe-eval' to its script-src",
            );
        throw error;
    }
}

export async function instantiate(source: BufferSource | WebAssembly.Module): Promise<Memory> {
    if (!hasSimd())
        throw new PenumbraError('NO_SIMD', 'this browser has no WebAssembly SIMD (Chrome 91, Firefox 89 and Safari 16.4 have)');
    const instance = await WebAssembly.instantiate(await compile(source), IMPORTS);
    return new Memory(instance.exports);
}
