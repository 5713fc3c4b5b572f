import type { Character } from './core.js';
import { openIrradiance, visibleIrradiance } from './sh.js';

/** The things that darken a character in a frame. */
export interface LossLight {
    /** Light in the model frame, [25, 3]; without one the darkening is that of a white sky, and costs least. */
    sh?: ArrayLike<number>;
    /** Bands of the light that count, 1 to 5 (default 5): fewer are faster. */
    order?: number;
    /** From 0 (nothing is darkened) to 1 (default). */
    strength?: number;
}

/** The share of its environment's light that each vertex of a character loses, in arrays that frames share. */
export class Loss {
    private open = new Float32Array(0);
    private visible = new Float32Array(0);

    /** Writes [V, 4] of an evaluated character: what each colour loses, from 0 to 1, and the ambient visibility E. */
    compute(character: Character, light: LossLight, out: Float32Array): void {
        const strength = light.strength ?? 1;
        if (light.sh) this.writeColours(character, { ...light, sh: light.sh, strength }, out);
        const ambient = character.ambient(); // the views from before are dead if memory grew
        for (let v = 0, at = 0; v < ambient.length; ++v, at += 4) {
            const lost = strength * (1 - ambient[v]);
            if (!light.sh) out[at] = out[at + 1] = out[at + 2] = lost;
            out[at + 3] = 1 - lost;
        }
    }

    private writeColours(character: Character, light: Required<Pick<LossLight, 'sh' | 'strength'>> & LossLight, out: Float32Array): void {
        const count = 3 * character.asset.vertexCount;
        const order = light.order ?? 5;
        if (this.open.length < count) {
            this.open = new Float32Array(count);
            this.visible = new Float32Array(count);
        }
        const { open, visible } = this;
        openIrradiance(light.sh, character.normals, open, order);
        visibleIrradiance(light.sh, character.transfer(order), visible, order);
        for (let i = 0, at = 0; i < count; at += 4)
            for (let k = 0; k < 3; ++k, ++i) {
                const share = open[i] > 0 ? visible[i] / open[i] : 1;
                out[at + k] = light.strength * (1 - Math.min(Math.max(share, 0), 1));
            }
    }
}
