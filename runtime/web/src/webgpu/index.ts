import type { DataTexture, Mesh } from 'three';
import { attribute, positionWorld, texture, uniform, varying, vec2, vec4 } from 'three/tsl';
import { PenumbraCharacter as ForWebGL } from '../three/character.js';
import { PenumbraGround as GroundForWebGL, type Squares } from '../three/ground.js';
import { patchMeshes, type Tsl } from './nodes.js';

export { GpuEvaluator } from './evaluate.js';
export { PenumbraEnvironment, type EquirectangularOptions } from '../three/environment.js';
export { PenumbraScene } from '../three/scene.js';
export { PenumbraLoader, assetOf } from '../three/loader.js';
export type { PenumbraCharacterOptions } from '../three/character.js';
export type { PenumbraGroundOptions } from '../three/ground.js';
export { PenumbraError, type PenumbraCode } from '../error.js';

let counter = 0;

/** The class of the same name of penumbra-player/three, for WebGPURenderer with either of its back ends. */
export class PenumbraCharacter extends ForWebGL {
    protected override patch(meshes: Mesh[]): (() => void)[] {
        const loss = (varying(attribute('penumbraLoss', 'vec4') as Tsl, 'vPenumbraLoss') as Tsl).setInterpolation('perspective', 'centroid');
        return patchMeshes(meshes, 'penumbra-vertex', (builder) => (builder.hasGeometryAttribute('penumbraLoss') ? loss : undefined));
    }
}

/** The class of the same name of penumbra-player/three, for WebGPURenderer with either of its back ends. */
export class PenumbraGround extends GroundForWebGL {
    protected override patch(mesh: Mesh, { map, areas, side }: Squares): (() => void)[] {
        const squares = areas.map((area, i) => squareOf(map, uniform(area) as Tsl, { i, count: areas.length, side }));
        const weight = squares.map((one) => one.inside).reduce((a, b) => a.add(b)).max(1);
        const lost = squares.map((one) => one.lost).reduce((a, b) => a.add(b)).div(weight);
        const loss = vec4(lost.rgb, lost.a.oneMinus());
        return patchMeshes([mesh], `penumbra-ground-${counter++}`, () => loss);
    }
}

/** Returns how far a point is inside of a square, and that times what it loses there; ground.ts has it for WebGL. */
function squareOf(map: DataTexture, area: Tsl, { i, count, side }: { i: number; count: number; side: number }): { inside: Tsl; lost: Tsl } {
    const at = (positionWorld as Tsl).xz.sub(area.xy).div(area.z);
    const inside = at.x.abs().max(at.y.abs()).mul(-4).add(4).clamp();
    const most = 1 - 1 / side;
    const texel = at.clamp(-most, most).mul(0.5).add(0.5);
    const found = texture(map, vec2(texel.x, texel.y.add(i).div(count))) as Tsl;
    return { inside, lost: vec4(found.rgb, found.a.oneMinus()).mul(inside) };
}
