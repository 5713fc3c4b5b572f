import { Asset, Character, type Runtime } from '../core.js';
import { PenumbraError } from '../error.js';
import { Loss } from '../loss.js';
import type { Answer, Opened, Request, Updated } from './messages.js';

/** The side of a worker that `self` is. */
export interface WorkerScope {
    onmessage: ((event: MessageEvent) => void) | null;
    postMessage(message: unknown, transfer: Transferable[]): void;
}

/** The assets and characters of one worker, by the numbers that the page has for them. */
class Service {
    private readonly objects = new Map<number, Asset | Character>();
    private readonly loss = new Loss();
    private last = 0;

    constructor(private readonly runtime: Runtime) {}

    answer(request: Request): unknown {
        switch (request.kind) {
            case 'open':
                return this.open(request.bytes);
            case 'create':
                return this.keep(new Character(this.get(request.asset, Asset)));
            case 'dispose':
                return this.forget(request.object);
            case 'update':
                return this.update(request);
        }
    }

    private open(bytes: ArrayBuffer | ArrayBufferView): Opened {
        const asset = this.runtime.open(bytes);
        const { vertexCount, jointNames, inputCount } = asset;
        return { object: this.keep(asset), vertexCount, jointCount: jointNames.length, inputCount };
    }
    private update(request: Request & { kind: 'update' }): Updated {
        const start = performance.now();
        const { matrices, inputs, update, loss } = request;
        const character = this.get(request.character, Character);
        character.setQuality(update.quality ?? 'full');
        character.poseMatrices.set(matrices);
        if (inputs.length > 0) character.setInputs(inputs);
        character.setPose();
        character.evaluate();
        this.loss.compute(character, update, loss);
        return { matrices, loss, ms: performance.now() - start };
    }
    /** An asset stays open while characters of it are there: they need it for their inputs. */
    private forget(object: number): void {
        const found = this.objects.get(object);
        this.objects.delete(object);
        if (found instanceof Character) found.dispose();
        const asset = found instanceof Character ? found.asset : found;
        const isNeeded = [...this.objects.values()].some((other) => other === asset || (other as Character).asset === asset);
        if (!isNeeded) asset?.dispose();
    }
    private keep(object: Asset | Character): number {
        this.objects.set(++this.last, object);
        return this.last;
    }
    private get<T>(object: number, type: abstract new (...values: never[]) => T): T {
        const found = this.objects.get(object);
        if (!(found instanceof type)) throw new PenumbraError('DISPOSED', 'this object was disposed of');
        return found;
    }
}

/** Makes a worker answer what a PenumbraWorker asks, in the order of the requests: `serve(self, load())`. */
export function serve(scope: WorkerScope, runtime: Runtime | Promise<Runtime>): void {
    const service = Promise.resolve(runtime).then((ready) => new Service(ready));
    scope.onmessage = async ({ data }: MessageEvent<Request & { id: number }>) => {
        const moved = data.kind === 'update' ? [data.matrices.buffer as ArrayBuffer, data.loss.buffer as ArrayBuffer] : [];
        let answer: Answer;
        try {
            answer = { id: data.id, value: (await service).answer(data) };
        } catch (error) {
            const code = error instanceof PenumbraError ? error.code : 'FAILED';
            answer = { id: data.id, error: { code, message: String((error as Error).message ?? error) } };
        }
        scope.postMessage(answer, 'value' in answer ? moved : []);
    };
}
