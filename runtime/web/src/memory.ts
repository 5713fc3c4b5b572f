import { PenumbraError, type PenumbraCode } from './error.js';

type Call = (...values: number[]) => number;

const CODES: PenumbraCode[] = ['FAILED', 'INVALID_ARGUMENT', 'IO_ERROR', 'INVALID_ASSET', 'FAILED', 'UNSUPPORTED', 'OUT_OF_MEMORY'];
const ERROR_SIZE = 512; // penumbra_error: a status, then the message

/** One instance of the module: its functions by their C names, and views of its memory. Views are made anew for every
 * use, because those made before memory grows are dead. */
export class Memory {
    private readonly exports: WebAssembly.Exports;
    private readonly memory: WebAssembly.Memory;
    private readonly error: number;
    /** Room for what a call hands out through pointers, 256 bytes. */
    readonly out: number;

    constructor(exports: WebAssembly.Exports) {
        this.exports = exports;
        this.memory = exports.memory as WebAssembly.Memory;
        this.call('__wasm_call_ctors');
        this.error = this.allocate(ERROR_SIZE);
        this.out = this.allocate(256);
    }

    /** Whether this module has a function: smaller ones lack some. */
    has(name: string): boolean {
        return name in this.exports;
    }
    /** Calls a function that cannot fail. */
    call(name: string, ...values: number[]): number {
        return (this.exports[name] as Call)(...values);
    }
    /** Calls a function whose last argument is a penumbra_error, and throws what it reports. */
    check(name: string, ...values: number[]): void {
        const status = this.call(name, ...values, this.error);
        if (status !== 0) throw new PenumbraError(CODES[status] ?? 'FAILED', this.text(this.error + 4));
    }

    allocate(bytes: number): number {
        const at = this.call('malloc', Math.max(bytes, 1)) >>> 0;
        if (at === 0) throw new PenumbraError('OUT_OF_MEMORY', `no memory for ${bytes} bytes`);
        return at;
    }
    free(at: number): void {
        this.call('free', at);
    }

    bytes(at: number, count: number): Uint8Array {
        return new Uint8Array(this.memory.buffer, at, count);
    }
    words(at: number, count: number): Uint32Array {
        return new Uint32Array(this.memory.buffer, at, count);
    }
    floats(at: number, count: number): Float32Array {
        return new Float32Array(this.memory.buffer, at, count);
    }
    word(at: number): number {
        return this.words(at, 1)[0];
    }
    text(at: number): string {
        if (at === 0) return '';
        const all = new Uint8Array(this.memory.buffer);
        return new TextDecoder().decode(all.slice(at, all.indexOf(0, at)));
    }
    get size(): number {
        return this.memory.buffer.byteLength;
    }
}

/** Arrays in the module's memory, which live as long as their owner. */
export class Arrays {
    private readonly list: number[] = [];

    constructor(private readonly memory: Memory) {}

    floats(count: number): number {
        const at = this.memory.allocate(4 * count);
        this.list.push(at);
        return at;
    }
    free(): void {
        for (const at of this.list.splice(0)) this.memory.free(at);
    }
}
