/** penumbra.wasm as base64 of gzip. build.mjs writes it. */
export declare const packed: string;
