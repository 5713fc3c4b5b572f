// usage: node web_times.mjs PACKAGE ASSET: milliseconds of one thread that a frame takes, least of rounds over all
// poses.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const [folder, file] = process.argv.slice(2);
const { Character, load } = await import(pathToFileURL(path.join(folder, 'dist/index.js')).href);
// The clock of this thread alone: compilers of JavaScript have threads of their own.
const now = () => Number(fs.readFileSync(`/proc/self/task/${process.pid}/schedstat`, 'utf8').split(' ')[0]) / 1e6;
const runtime = await load();
const asset = runtime.open(fs.readFileSync(file));
const character = new Character(asset);
let least = Infinity;
for (let round = 0; round < 6; ++round) {
    const begin = now();
    for (let frame = 0; frame < asset.frameCount; frame += 3) {
        character.setFrame(frame);
        character.evaluate();
        character.ambient();
    }
    least = Math.min(least, (now() - begin) / Math.ceil(asset.frameCount / 3));
}
console.log(least);
