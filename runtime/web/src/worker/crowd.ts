import type { LossLight } from '../loss.js';
import type { PenumbraWorker, WorkerCharacter } from './client.js';
import type { WorkerUpdate } from './messages.js';

/** One of many characters on a page. */
export interface CrowdMember {
    readonly character: WorkerCharacter;
    /** How far it is from who looks, in any unit that all members share. */
    distance(): number;
    /** Fills the matrices of its joints, as WorkerCharacter.update wants them. */
    writePose(matrices: Float32Array): void;
    /** Values of the asset's inputs; absent where it has none. */
    inputs?(): ArrayLike<number>;
    /** Light in its model frame, of which its level takes as many bands as it wants; absent for a white sky. */
    light?(): LossLight;
    /** Shows what the worker has found, [V, 4], which is dead after the next call. */
    apply(loss: Float32Array): void;
}

/** How the members of one stretch of the distance are updated. */
export interface CrowdLevel {
    /** How many members it has, the nearest ones that no level before it took. */
    count: number;
    /** Updates a second that each of them shall have. */
    rate: number;
    quality: NonNullable<WorkerUpdate['quality']>;
    /** Bands of the light that count; 0 is a white sky, which costs least. */
    order: number;
}

/** Less than one core for 50 additive characters of 7,000 vertices (docs/web.md). */
export const LEVELS: readonly CrowdLevel[] = [
    { count: 12, rate: 30, quality: 'full', order: 0 },
    { count: Infinity, rate: 5, quality: 'fast', order: 0 },
];

interface Entry {
    member: CrowdMember;
    level: CrowdLevel;
    last: number;
    busy: boolean;
}

/** Updates many characters in workers, near ones more often than far ones. Where a worker cannot do all of its own, all
 * levels slow down alike. */
export class Crowd {
    /** Updates that a worker has not answered yet: enough that it never waits, and few enough that poses are fresh. */
    private static readonly AHEAD = 3;
    /** Called where an update has failed (default: console.error). The next one comes when the member is due again. */
    onerror: ((error: unknown) => void) | undefined;
    /** Updates that were shown since the crowd was made. */
    updates = 0;
    private readonly entries = new Map<CrowdMember, Entry>();
    private now = 0;
    private readonly flying = new WeakMap<PenumbraWorker, number>();

    constructor(private readonly levels: readonly CrowdLevel[] = LEVELS) {}

    /** Answers the member, which `remove` wants. */
    add<T extends CrowdMember>(member: T): T {
        this.entries.set(member, { member, level: this.levels[0], last: -Infinity, busy: false });
        return member;
    }
    /** An update under way is not shown. The character is the caller's to dispose of. */
    remove(member: CrowdMember): void {
        this.entries.delete(member);
    }
    /** Once a frame, after the mixers: `now` is in milliseconds. */
    update(now: number = performance.now()): void {
        this.now = now;
        this.assignLevels();
        this.send();
    }

    private assignLevels(): void {
        const order = [...this.entries.values()].map((entry) => ({ entry, distance: entry.member.distance() }));
        order.sort((a, b) => a.distance - b.distance);
        let [level, left] = [0, this.levels[0].count];
        for (const { entry } of order) {
            while (left <= 0 && level + 1 < this.levels.length) left = this.levels[++level].count;
            --left;
            entry.level = this.levels[level];
        }
    }
    private underWay({ member }: Entry): number {
        return this.flying.get(member.character.asset.worker) ?? 0;
    }
    /** The member that has waited longest, in its own intervals, for a worker that has room; none before its time. */
    private mostLate(): Entry | undefined {
        let [found, most] = [undefined as Entry | undefined, 1 - 1e-6];
        for (const entry of this.entries.values()) {
            const late = ((this.now - entry.last) * entry.level.rate) / 1000;
            if (!entry.busy && late >= most && this.underWay(entry) < Crowd.AHEAD) [found, most] = [entry, late];
        }
        return found;
    }
    /** When the interval begins that an update ends now. Frames come a little early or late: the next update is due an
     * interval after this one was, not after it came. */
    private nextStart({ last, level }: Entry): number {
        const interval = 1000 / level.rate;
        return this.now - last < 2 * interval ? last + interval : this.now;
    }
    private send(): void {
        for (let entry = this.mostLate(); entry; entry = this.mostLate()) this.start(entry);
    }
    private start(entry: Entry): void {
        const { worker } = entry.member.character.asset;
        this.flying.set(worker, this.underWay(entry) + 1);
        entry.busy = true;
        entry.last = this.nextStart(entry);
        this.run(entry)
            .catch((error) => {
                if (this.entries.has(entry.member)) (this.onerror ?? console.error)(error); // or it was taken out
            })
            .finally(() => {
                this.flying.set(worker, this.underWay(entry) - 1);
                entry.busy = false;
                this.send();
            });
    }
    private async run({ member, level }: Entry): Promise<void> {
        const { quality, order } = level;
        const { sh, strength } = member.light?.() ?? {};
        const light = order > 0 ? { sh, strength, order } : { strength };
        const write = (matrices: Float32Array) => member.writePose(matrices);
        const loss = await member.character.update(write, member.inputs?.() ?? [], { quality, ...light });
        if (!this.entries.has(member)) return;
        member.apply(loss);
        ++this.updates;
    }
}
