// How a crowd shares out a worker's time, with a clock and a worker that are made up.
//
// usage: node crowd.mjs PACKAGE
import assert from 'node:assert/strict';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const { Crowd, LEVELS } = await import(pathToFileURL(path.join(process.argv[2], 'dist/worker/index.js')).href);
const MEMBERS = 50;
const NEAR = 12;

/** Updates a second of each of 50 members, nearest first, by workers that each do so many in a frame of 1/60 s. */
async function ratesOf(perFrame, seconds, workers = 1) {
    const queues = Array.from({ length: workers }, () => []);
    const crowd = new Crowd([{ ...LEVELS[0], order: 3 }, LEVELS[1]]);
    const updates = new Array(MEMBERS).fill(0);
    for (let i = 0; i < MEMBERS; ++i) {
        const queue = queues[i % workers];
        const character = {
            asset: { worker: queue },
            update: (write, inputs, how) => {
                assert.deepEqual([how.quality, how.order], i < NEAR ? ['full', 3] : ['fast', undefined]);
                return new Promise((resolve) => queue.push(resolve));
            },
        };
        crowd.add({ character, distance: () => i, writePose: () => undefined, light: () => ({ sh: [] }), apply: () => ++updates[i] });
    }
    for (let frame = 0; frame < 60 * seconds; ++frame) {
        crowd.update((1000 * frame) / 60 + 0.5 * Math.sin(17.3 * frame)); // frames are never quite on time
        for (const queue of queues)
            for (let done = 0; done < perFrame && queue.length > 0; ++done) {
                queue.shift()();
                for (let turn = 0; turn < 5; ++turn) await null; // the crowd goes on so when an answer comes
            }
    }
    return updates.map((count) => count / seconds);
}

const enough = await ratesOf(20, 4);
assert.ok(Math.min(...enough.slice(0, NEAR)) >= 29.5 && Math.min(...enough.slice(NEAR)) >= 5, String(enough));
assert.ok(Math.max(...enough) <= 30.5 && Math.max(...enough.slice(NEAR)) <= 6, String(enough));
// 300 of the 550 updates that are wanted: each level keeps its share.
const short = await ratesOf(5, 8);
const mean = (list) => list.reduce((sum, value) => sum + value, 0) / list.length;
const [near, far] = [mean(short.slice(0, NEAR)), mean(short.slice(NEAR))];
assert.ok(near > 12 && near < 20 && far > 2 && far < 4, `${near} ${far}`);
// Two workers of that speed do all, since neither waits for the other.
const shared = await ratesOf(5, 4, 2);
assert.ok(Math.min(...shared.slice(0, NEAR)) >= 29.5 && Math.min(...shared.slice(NEAR)) >= 5, String(shared));
console.log(`crowd: ${near.toFixed(1)} and ${far.toFixed(1)} updates a second where there is time for 300 of 550`);
