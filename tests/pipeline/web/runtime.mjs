// Holds the npm package against what the C library computed natively, and tries what must be refused.
//
// usage: node runtime.mjs PACKAGE FOLDER HOSTILE
// FOLDER has *.pnb, and beside each of them *.native: for each frame in it positions [V,3], E [V] and E of points
// [POINTS] under the character, float32.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const [folder, cases, hostile] = process.argv.slice(2);
const { Character, PenumbraError, Scene, ScenePoints, Shading, load } = await import(
    pathToFileURL(path.join(folder, 'dist/index.js')).href
);
const fileEntry = await import(pathToFileURL(path.join(folder, 'dist/no-inline.js')).href);
const lights = await import(pathToFileURL(path.join(folder, 'dist/sh.js')).href);
const POINTS = 16; // a side
const SPACING = 0.125; // metres

const runtime = await load();
assert.equal(await load(), runtime, 'one instance for all');
const sideBySide = await fileEntry.load(fs.readFileSync(path.join(folder, 'dist/penumbra.wasm')));
assert.equal(sideBySide.version, runtime.version);

function throwsCode(code, run) {
    assert.throws(run, (error) => error instanceof PenumbraError && error.code === code && error.message !== '', code);
}

/** The largest difference, which NaN and other sizes do not pass. */
function difference(a, b) {
    assert.ok(a.length === b.length && a.length > 0);
    let most = 0;
    for (let i = 0; i < a.length; ++i) {
        const d = Math.abs(a[i] - b[i]);
        if (!(d <= most)) most = d;
    }
    return most;
}

function groundPoints() {
    const positions = [];
    for (let row = 0; row < POINTS; ++row)
        for (let column = 0; column < POINTS; ++column)
            positions.push((column - POINTS / 2) * SPACING, 0, (row - POINTS / 2) * SPACING);
    return new ScenePoints(runtime, positions, positions.map((_, i) => (i % 3 === 1 ? 1 : 0)));
}

/** Differs from the native library by no more than `bound` in E. */
function checkParity(file, bound) {
    const asset = runtime.open(fs.readFileSync(file));
    const native = fs.readFileSync(file.replace(/pnb$/, 'native'));
    const numbers = new Float32Array(native.buffer, native.byteOffset, native.length / 4);
    const character = new Character(asset);
    const scene = asset.casts ? new Scene(runtime, [asset]) : null;
    const points = groundPoints();
    const worst = [0, 0, 0];
    let at = 0;
    const held = (what, ours) => {
        const d = difference(ours, numbers.subarray(at, (at += ours.length)));
        if (!(d <= worst[what])) worst[what] = d;
    };
    for (let frame = 0; frame < asset.frameCount; ++frame) {
        character.setFrame(frame);
        character.evaluate();
        held(0, character.positions);
        held(1, character.ambient());
        if (!scene) continue;
        scene.setCaster(0, character);
        held(2, points.ambient(scene));
    }
    assert.equal(at, numbers.length);
    console.log(
        `${path.basename(file)}: ${asset.frameCount} frames of ${asset.vertexCount} vertices; positions off by ` +
            `${worst[0]}, E by ${worst[1].toExponential(1)}, E of points by ${worst[2].toExponential(1)}`,
    );
    assert.ok(worst[0] === 0 && worst[1] <= bound && worst[2] <= bound, path.basename(file));
    // Everything may be given back in any order, and twice.
    asset.dispose();
    for (const one of [scene, character, points, asset, character]) one?.dispose();
    throwsCode('DISPOSED', () => character.ambient());
    throwsCode('DISPOSED', () => new Character(asset));
}

/** Lights of the page and transfer of the library speak of the same functions. */
function checkLights(whole) {
    const value = new Float64Array(25);
    const radiance = (sh, direction) => {
        lights.basis(...direction, value);
        return value.reduce((sum, y, i) => sum + y * sh[3 * i + 1], 0);
    };
    const light = Float32Array.from({ length: 75 }, (_, i) => Math.sin(1.7 * i));
    const [c, s] = [Math.cos(0.7), Math.sin(0.7)];
    const turned = lights.rotateLight(light, [c, 0, -s, 0, 1, 0, s, 0, c]); // columns: about y
    for (let k = 0; k < 20; ++k) {
        const [x, y, z] = [Math.sin(k), Math.cos(3 * k), Math.sin(5 * k + 1)].map((v, _, all) => v / Math.hypot(...all));
        assert.ok(Math.abs(radiance(turned, [c * x + s * z, y, c * z - s * x]) - radiance(light, [x, y, z])) < 1e-6);
    }
    const white = lights.projectPicture({ width: 64, height: 32, channels: 3, value: () => 1, fromTop: false });
    const asset = runtime.open(whole);
    const character = new Character(asset);
    character.setFrame(1);
    character.evaluate();
    const open = new Float32Array(3 * asset.vertexCount);
    lights.openIrradiance(white, character.normals, open);
    const visible = new Float32Array(3 * asset.vertexCount);
    lights.visibleIrradiance(white, character.transfer(5), visible);
    const e = character.ambient();
    // The picture's rows integrate with an error of 4e-4.
    for (let v = 0; v < asset.vertexCount; ++v) {
        assert.ok(Math.abs(open[3 * v] - Math.PI) < 4e-3, open[3 * v]);
        assert.ok(Math.abs(visible[3 * v] - Math.PI * e[v]) < 4e-3, `${visible[3 * v]} ${Math.PI * e[v]}`);
    }
    character.dispose();
    asset.dispose();
}

/** Radiance of assets that have materials; others are refused by name. */
function checkShading(file) {
    const asset = runtime.open(fs.readFileSync(file));
    if (asset.materialCount === 0) throwsCode('UNSUPPORTED', () => new Shading(asset));
    else {
        const character = new Character(asset);
        character.evaluate();
        const shading = new Shading(asset);
        const radiance = shading.shade(character, [0, 1, 4]);
        assert.equal(radiance.length, 3 * asset.vertexCount);
        assert.ok(radiance.every(Number.isFinite) && radiance.some((value) => value > 0.01));
        shading.dispose();
        character.dispose();
    }
    asset.dispose();
}

/** The module is as it was after any number of damaged files. */
function checkHostile(whole) {
    let refused = 0;
    for (const name of fs.readdirSync(hostile)) {
        const bytes = fs.readFileSync(path.join(hostile, name));
        for (let variant = 0; variant < 40; ++variant) {
            const damaged = Uint8Array.from(bytes.subarray(0, variant % 2 ? bytes.length : (bytes.length * variant) / 40));
            if (variant % 2) damaged[(damaged.length * variant) / 40 | 0] ^= 1 << variant % 8;
            try {
                const asset = runtime.open(damaged);
                if (asset.hasModel) new Character(asset).dispose();
                asset.dispose();
            } catch (error) {
                assert.ok(error instanceof PenumbraError, `${name}: ${error}`);
                ++refused;
            }
        }
    }
    assert.ok(refused > 100, refused);
    throwsCode('INVALID_ASSET', () => runtime.open(new Uint8Array(0)));
    // Nothing of this is memory that is lost, or a module that traps from now on.
    const asset = runtime.open(whole);
    const character = new Character(asset);
    character.setFrame(0);
    character.evaluate();
    assert.ok(character.ambient().every((e) => e >= -1e-3 && e <= 1.001));
    throwsCode('INVALID_ARGUMENT', () => character.setFrame(asset.frameCount));
    throwsCode('INVALID_ARGUMENT', () => character.setPose([1, 2, 3]));
    throwsCode('INVALID_ARGUMENT', () => character.setPose(new Float32Array(16 * asset.jointNames.length).fill(NaN)));
    character.dispose();
    asset.dispose();
    console.log(`${refused} damaged files refused`);
}

function checkGrowth(whole) {
    const round = () => {
        const asset = runtime.open(whole);
        const character = new Character(asset);
        const scene = asset.casts ? new Scene(runtime, [asset]) : null;
        character.evaluate();
        scene?.setCaster(0, character);
        for (const one of [asset, scene, character]) one?.dispose();
    };
    for (let i = 0; i < 10; ++i) round();
    const before = runtime.memoryBytes;
    for (let i = 0; i < 1000; ++i) round();
    assert.equal(runtime.memoryBytes, before, 'memory grows');
    console.log(`1,000 characters came and went in ${(before / 2 ** 20).toFixed(1)} MiB`);
}

const files = fs.readdirSync(cases).filter((name) => name.endsWith('.pnb'));
assert.ok(files.length > 0);
for (const name of files) checkParity(path.join(cases, name), name.startsWith('additive') ? 1e-6 : 1e-4);
for (const name of files) checkShading(path.join(cases, name));
const smallest = fs.readFileSync(path.join(cases, files.sort()[0]));
checkLights(smallest);
checkHostile(smallest);
checkGrowth(smallest);
await assert.rejects(fileEntry.load(new Uint8Array([1, 2, 3])), WebAssembly.CompileError);
console.log('npm package in node: ok');
