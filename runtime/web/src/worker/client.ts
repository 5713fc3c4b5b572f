import { PenumbraError } from '../error.js';
import type { Answer, Opened, Request, Updated, WorkerUpdate } from './messages.js';

interface Waiting {
    resolve: (value: never) => void;
    reject: (error: PenumbraError) => void;
}

/** Starts the package's own worker, which has the module inside. */
export function startWorker(): Worker {
    return new Worker(new URL('../worker-thread.js', import.meta.url), { type: 'module' });
}

/**
 * One module in a worker, which evaluates characters while the page draws. The worker is one that `startWorker`
 * started, or any that calls `serve`.
 */
export class PenumbraWorker {
    private readonly waiting = new Map<number, Waiting>();
    private last = 0;
    /** Why nothing can be asked any more. */
    private ended: PenumbraError | undefined;

    constructor(private readonly worker: Worker) {
        worker.onmessage = ({ data }: MessageEvent<Answer>) => this.receive(data);
        worker.onerror = (event) => this.end(new PenumbraError('FAILED', `the worker has failed: ${event.message ?? 'it does not load'}`));
    }

    /** Opens the bytes of a .pnb file there. They are copied. */
    async open(bytes: ArrayBuffer | ArrayBufferView): Promise<WorkerAsset> {
        return new WorkerAsset(this, await this.ask<Opened>({ kind: 'open', bytes }));
    }
    /** Ends the worker and all that is in it. A second call does nothing. */
    dispose(): void {
        this.worker.terminate();
        this.end(new PenumbraError('DISPOSED', 'the worker was ended'));
    }

    /** @internal */
    ask<T>(request: Request, moved: Transferable[] = []): Promise<T> {
        if (this.ended) return Promise.reject(this.ended);
        return new Promise<T>((resolve, reject) => {
            const id = ++this.last;
            // This throws if the request cannot be sent, so nobody waits for it.
            this.worker.postMessage({ ...request, id }, moved);
            this.waiting.set(id, { resolve, reject });
        });
    }
    /** @internal */
    forget(object: number): void {
        if (!this.ended) this.ask({ kind: 'dispose', object }).catch(() => undefined);
    }

    private receive(answer: Answer): void {
        const waiting = this.waiting.get(answer.id);
        this.waiting.delete(answer.id);
        if ('error' in answer) waiting?.reject(new PenumbraError(answer.error.code, answer.error.message));
        else waiting?.resolve(answer.value as never);
    }
    private end(error: PenumbraError): void {
        this.ended ??= error;
        for (const { reject } of this.waiting.values()) reject(error);
        this.waiting.clear();
    }
}

/** An asset in a worker. */
export class WorkerAsset {
    readonly vertexCount: number;
    readonly jointCount: number;
    readonly inputCount: number;

    /** @internal */
    constructor(
        /** @internal */ readonly worker: PenumbraWorker,
        private readonly opened: Opened,
    ) {
        this.vertexCount = opened.vertexCount;
        this.jointCount = opened.jointCount;
        this.inputCount = opened.inputCount;
    }
    async create(): Promise<WorkerCharacter> {
        return new WorkerCharacter(this, await this.worker.ask<number>({ kind: 'create', asset: this.opened.object }));
    }
    /** Characters that were made of it live on, and the worker keeps it until the last of them is disposed of. */
    dispose(): void {
        this.worker.forget(this.opened.object);
    }
}

/** A character in a worker. */
export class WorkerCharacter {
    /** How long the worker took for the last update, in milliseconds. */
    ms = 0;
    // Arrays that came back, for the next updates.
    private readonly spareMatrices: Float32Array[] = [];
    private readonly spareLosses: Float32Array[] = [];
    private shown: Float32Array | undefined;

    /** @internal */
    constructor(
        readonly asset: WorkerAsset,
        private readonly object: number,
    ) {}

    /**
     * Evaluates a pose. `write` fills J matrices of 4 x 4 columns, joint in the model frame times inverse bind; joints
     * that stand for inputs follow from `inputs`. Answers what each vertex loses of each colour, and E: [V, 4], which
     * belongs to the caller until the answer of a later update.
     */
    async update(write: (matrices: Float32Array) => void, inputs: ArrayLike<number>, update: WorkerUpdate = {}): Promise<Float32Array> {
        const { worker, jointCount, vertexCount } = this.asset;
        const matrices = this.spareMatrices.pop() ?? new Float32Array(16 * jointCount);
        const loss = this.spareLosses.pop() ?? new Float32Array(4 * vertexCount);
        write(matrices);
        const request: Request = { kind: 'update', character: this.object, matrices, inputs, update, loss };
        const answer = await worker.ask<Updated>(request, [matrices.buffer, loss.buffer] as ArrayBuffer[]);
        this.spareMatrices.push(answer.matrices);
        if (this.shown) this.spareLosses.push(this.shown);
        this.shown = answer.loss;
        this.ms = answer.ms;
        return answer.loss;
    }
    /** A second call does nothing. Updates that come later are refused with DISPOSED. */
    dispose(): void {
        this.asset.worker.forget(this.object);
    }
}
