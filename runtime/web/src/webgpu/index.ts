import type { DataTexture, Mesh, Vector3 } from 'three';
import { attribute, positionWorld, texture, uniform, varying, vec4 } from 'three/tsl';
import { PenumbraCharacter as ForWebGL } from '../three/character.js';
import { PenumbraGround as GroundForWebGL } from '../three/ground.js';
import { patchMeshes, type Tsl } from './nodes.js';

export { GpuEvaluator } from './evaluate.js';
export { PenumbraEnvironment } from '../three/environment.js';
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
    protected override patch(mesh: Mesh, map: DataTexture, area: Vector3): (() => void)[] {
        const square = uniform(area) as Tsl;
        const at = (positionWorld as Tsl).xz.sub(square.xy).div(square.z);
        const lost = texture(map, at.mul(0.5).add(0.5)) as Tsl;
        // Nothing is lost at the border of the square and beyond.
        const inside = at.x.abs().max(at.y.abs()).mul(-4).add(4).clamp();
        const loss = vec4(lost.rgb.mul(inside), lost.a.oneMinus().mul(inside).oneMinus());
        return patchMeshes([mesh], `penumbra-ground-${counter++}`, () => loss);
    }
}
