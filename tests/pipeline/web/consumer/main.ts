// A page of somebody else's project: every entry of the package, with its types.
import { Object3D } from 'three';
import { Character, load, type Asset } from 'penumbra-player';
import { load as loadFile } from 'penumbra-player/no-inline';
import wasm from 'penumbra-player/penumbra.wasm?url';
import { openIrradiance } from 'penumbra-player/sh';
import { PenumbraCharacter, PenumbraError } from 'penumbra-player/three';
import { GpuEvaluator } from 'penumbra-player/three/webgpu';
import { Crowd, PenumbraWorker, startWorker, type CrowdLevel } from 'penumbra-player/worker';

const found: Record<string, unknown> = {};
const levels: CrowdLevel[] = [{ count: 1, rate: 10, quality: 'full', order: 0 }];

function isUnmatched(asset: Asset): boolean {
    try {
        new PenumbraCharacter(asset, new Object3D());
        return false;
    } catch (error) {
        return error instanceof PenumbraError;
    }
}

async function main(): Promise<void> {
    const bytes = await (await fetch('/files/additive.pnb')).arrayBuffer();
    const asset = (await load()).open(bytes);
    const character = new Character(asset);
    character.evaluate();
    const open = new Float32Array(3 * asset.vertexCount);
    openIrradiance(new Float32Array(75), character.normals, open);
    found.vertices = character.ambient().length;
    found.file = (await loadFile(wasm)).version;
    const there = await new PenumbraWorker(startWorker()).open(bytes);
    const one = await there.create();
    const loss = await one.update((matrices) => matrices.forEach((_, i) => (matrices[i] = i % 16 % 5 === 0 ? 1 : 0)), []);
    found.worker = loss.length / 4;
    found.three = isUnmatched(asset) && typeof GpuEvaluator === 'function' && new Crowd(levels).updates === 0;
}

main()
    .catch((error: unknown) => (found.error = String(error)))
    .finally(() => console.log('FOUND ' + JSON.stringify(found)));
