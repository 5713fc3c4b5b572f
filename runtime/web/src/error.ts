/** The names of penumbra_status, and what only a browser can refuse. */
export type PenumbraCode =
    | 'INVALID_ARGUMENT'
    | 'IO_ERROR'
    | 'INVALID_ASSET'
    | 'FAILED'
    | 'UNSUPPORTED'
    | 'OUT_OF_MEMORY'
    | 'NO_SIMD'
    | 'BLOCKED_BY_CSP'
    | 'DISPOSED'
    | 'UNMATCHED';

export class PenumbraError extends Error {
    readonly code: PenumbraCode;

    constructor(code: PenumbraCode, message: string) {
        super(message);
        this.name = 'PenumbraError';
        this.code = code;
    }
}
