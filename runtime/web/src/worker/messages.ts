import type { Quality } from '../core.js';
import type { PenumbraCode } from '../error.js';
import type { LossLight } from '../loss.js';

/** The values that a character is asked to compute. */
export interface WorkerUpdate extends LossLight {
    quality?: Quality;
}
/** A request of a page to a worker. Arrays of an update change hands, and come back with the answer. */
export type Request =
    | { kind: 'open'; bytes: ArrayBuffer | ArrayBufferView }
    | { kind: 'create'; asset: number }
    | { kind: 'dispose'; object: number }
    | { kind: 'update'; character: number; matrices: Float32Array; inputs: ArrayLike<number>; update: WorkerUpdate; loss: Float32Array };
export interface Opened {
    object: number;
    vertexCount: number;
    jointCount: number;
    inputCount: number;
}
export interface Updated {
    matrices: Float32Array;
    loss: Float32Array;
    /** How long the worker took, in milliseconds. */
    ms: number;
}
export type Answer = { id: number } & ({ value: unknown } | { error: { code: PenumbraCode; message: string } });
