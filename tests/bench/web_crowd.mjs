// Processor time of what a worker does for a crowd: one update of each level, and a second of 12 near and 38 far
// members.
//
// usage: node web_crowd.mjs PACKAGE X.pnb
// The figures are of the processor's time, so other work on the machine matters little.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const [folder, file] = process.argv.slice(2);
const from = async (name) => import(pathToFileURL(path.join(folder, 'dist', name)).href);
const { Character, load } = await from('index.js');
const { LEVELS, serve } = await from('worker/index.js');
const UPDATES = 100;
const MEMBERS = [12, 38];

/** A worker without a thread: answers come as promises. */
async function service() {
    const waiting = new Map();
    const scope = { onmessage: null, postMessage: (answer) => waiting.get(answer.id)(answer.value) };
    serve(scope, load());
    let last = 0;
    return (request) =>
        new Promise((resolve) => {
            waiting.set(++last, resolve);
            scope.onmessage({ data: { ...request, id: last } });
        });
}

const bytes = fs.readFileSync(file);
const asset = (await load()).open(bytes);
const ask = await service();
const { object } = await ask({ kind: 'open', bytes });
const character = await ask({ kind: 'create', asset: object });
const loss = new Float32Array(4 * asset.vertexCount);
const sh = Float32Array.from({ length: 75 }, (_, i) => (i < 3 ? 3 : Math.sin(i)));

/** Joints that turn a little, each about the axis z of its own frame. */
function pose(k) {
    const matrices = new Float32Array(16 * asset.jointNames.length);
    for (let j = 0; j < asset.jointNames.length; ++j) {
        const angle = 0.1 * Math.sin(k + j);
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        matrices.set([c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], 16 * j);
    }
    return matrices;
}

async function millisecondsOf(update) {
    const poses = Array.from({ length: UPDATES }, (_, k) => pose(k));
    const run = (matrices) => ask({ kind: 'update', character, matrices, inputs: [], update, loss });
    for (const matrices of poses) await run(matrices);
    const before = process.cpuUsage();
    for (const matrices of poses) await run(matrices);
    const { user, system } = process.cpuUsage(before);
    return (user + system) / 1000 / UPDATES;
}

const levels = [...LEVELS, { ...LEVELS[0], order: 3 }, { ...LEVELS[0], order: 5 }];
const times = [];
for (const { quality, order } of levels) {
    times.push(await millisecondsOf(order > 0 ? { quality, sh, order } : { quality }));
    console.log(`${quality}, ${order === 0 ? 'white sky' : `${order} bands in colour`}: ${times.at(-1).toFixed(2)} ms an update`);
}
const second = (near) => (MEMBERS[0] * LEVELS[0].rate * near + MEMBERS[1] * LEVELS[1].rate * times[1]).toFixed(0);
console.log(
    `50 characters of ${asset.vertexCount} vertices: ${second(times[0])} ms a second, ${second(times[2])} where the near ones ` +
        'have 3 bands in colour',
);
