import { DataUtils, type DataTexture, type Matrix4 } from 'three';
import { PenumbraError } from '../error.js';
import { projectPicture, rotateLight } from '../sh.js';

/** The light of a scene's environment, as spherical harmonics of order 5 in the frame of the world. */
export class PenumbraEnvironment {
    private turned: Float32Array;

    /** `sh` is [25, 3]: radiance in linear Rec.709, real and orthonormal with the Condon-Shortley sign. */
    constructor(private readonly sh: Float32Array) {
        if (sh.length !== 75) throw new PenumbraError('INVALID_ARGUMENT', `${sh.length} numbers are no light of order 5`);
        this.turned = sh;
    }

    /** From an equirectangular picture with its pixels at hand, as EXRLoader and HDRLoader give it. */
    static fromEquirectangular(texture: DataTexture): PenumbraEnvironment {
        const { data, width, height } = texture.image as { data: ArrayLike<number>; width: number; height: number };
        if (!data || data.length === 0)
            throw new PenumbraError('UNSUPPORTED', 'the texture has no pixels in memory: give the one that a loader returned');
        const half = data instanceof Uint16Array;
        if (!half && !(data instanceof Float32Array))
            throw new PenumbraError('UNSUPPORTED', 'the pixels of an environment must be float or half float');
        const value = half ? (i: number) => DataUtils.fromHalfFloat(data[i]) : (i: number) => data[i];
        const channels = data.length / (width * height);
        return new PenumbraEnvironment(projectPicture({ width, height, channels, value, fromTop: texture.flipY }));
    }

    /** Turns the environment by this matrix, as scene.environmentRotation does. */
    setRotation(rotation: Matrix4): void {
        this.turned = rotateLight(this.sh, rotationOf(rotation));
    }
    get world(): Float32Array {
        return this.turned;
    }
    /** @internal The light in the frame of an object. */
    inFrameOf(matrixWorld: Matrix4): Float32Array {
        const c = rotationOf(matrixWorld);
        return rotateLight(this.turned, [c[0], c[3], c[6], c[1], c[4], c[7], c[2], c[5], c[8]]);
    }
}

/** The columns of a matrix without its scale. */
function rotationOf(matrix: Matrix4): number[] {
    const e = matrix.elements;
    return [0, 4, 8].flatMap((c) => {
        const length = Math.hypot(e[c], e[c + 1], e[c + 2]);
        return [e[c] / length, e[c + 1] / length, e[c + 2] / length];
    });
}
