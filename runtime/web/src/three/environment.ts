import {
    DataTexture,
    DataUtils,
    DirectionalLight,
    EquirectangularReflectionMapping,
    FloatType,
    LinearFilter,
    Matrix4,
    RGBAFormat,
    type Texture,
    type WebGLRenderer,
} from 'three';
import { PenumbraError } from '../error.js';
import { projectPicture, rotateLight, takeSuns, type Equirectangular, type Sun } from '../sh.js';
import { projectFaces, readFaces } from './pmrem.js';

export interface EquirectangularOptions {
    /** How many suns at most become lights of their own (default 0: the picture stays whole). */
    suns?: number;
}

// A directional light has a place alone for its shadow map: this far from its target, in metres.
const SUN_DISTANCE = 5;

/** The light of a scene's environment, as spherical harmonics of order 5 in the frame of the world. */
export class PenumbraEnvironment {
    /** One for each sun of the environment. Add them and their targets to the scene, and give them shadow maps; where
     * the environment turns, they turn about their targets. */
    readonly lights: readonly DirectionalLight[];
    /** The picture without its suns, for `scene.environment`: with the whole picture there they would count twice.
     * Undefined where no sun was taken out of a picture. */
    readonly soft: DataTexture | undefined;
    private turned: Float32Array;

    /** `sh` is [25, 3]: radiance in linear Rec.709, real and orthonormal with the Condon-Shortley sign. No suns. */
    constructor(
        private readonly sh: Float32Array,
        private readonly suns: readonly Sun[] = [],
        soft?: DataTexture,
    ) {
        if (sh.length !== 75) throw new PenumbraError('INVALID_ARGUMENT', `${sh.length} numbers are no light of order 5`);
        this.turned = sh;
        this.soft = soft;
        this.lights = suns.map(lightOf);
        this.turnLights(new Matrix4());
    }

    /** From an equirectangular picture with its pixels at hand, as EXRLoader and HDRLoader give it. */
    static fromEquirectangular(texture: DataTexture, options: EquirectangularOptions = {}): PenumbraEnvironment {
        const picture = pictureOf(texture);
        const most = options.suns ?? 0;
        if (most === 0) return new PenumbraEnvironment(projectPicture(picture));
        const pixels = coloursOf(picture);
        const suns = takeSuns(picture, pixels, most);
        const rest = { ...picture, channels: 3, value: (i: number) => pixels[i] };
        return new PenumbraEnvironment(projectPicture(rest), suns, suns.length > 0 ? textureOf(rest, texture) : undefined);
    }

    /** Takes a texture of PMREMGenerator or another cube, as `scene.environment` may have it. Suns stay in it. */
    static async fromPMREM(renderer: WebGLRenderer, texture: Texture): Promise<PenumbraEnvironment> {
        return new PenumbraEnvironment(projectFaces(readFaces(renderer, texture)));
    }

    /** Turns the environment by this matrix, as scene.environmentRotation does, and its lights. */
    setRotation(rotation: Matrix4): void {
        this.turned = rotateLight(this.sh, rotationOf(rotation));
        this.turnLights(rotation);
    }
    get world(): Float32Array {
        return this.turned;
    }
    /** @internal The light in the frame of an object. */
    inFrameOf(matrixWorld: Matrix4): Float32Array {
        const c = rotationOf(matrixWorld);
        return rotateLight(this.turned, [c[0], c[3], c[6], c[1], c[4], c[7], c[2], c[5], c[8]]);
    }

    private turnLights(rotation: Matrix4): void {
        this.suns.forEach(({ direction }, i) => {
            const { position, target } = this.lights[i];
            position.fromArray(direction).transformDirection(rotation).multiplyScalar(SUN_DISTANCE).add(target.position);
        });
    }
}

function lightOf({ irradiance }: Sun): DirectionalLight {
    const intensity = Math.max(...irradiance);
    const light = new DirectionalLight(0xffffff, intensity);
    light.color.setRGB(irradiance[0] / intensity, irradiance[1] / intensity, irradiance[2] / intensity);
    return light;
}

function pictureOf(texture: DataTexture): Equirectangular {
    const { data, width, height } = texture.image as { data: ArrayLike<number>; width: number; height: number };
    if (!data || data.length === 0)
        throw new PenumbraError('UNSUPPORTED', 'the texture has no pixels in memory: give the one that a loader returned');
    const half = data instanceof Uint16Array;
    if (!half && !(data instanceof Float32Array))
        throw new PenumbraError('UNSUPPORTED', 'the pixels of an environment must be float or half float');
    const value = half ? (i: number) => DataUtils.fromHalfFloat(data[i]) : (i: number) => data[i];
    return { width, height, channels: data.length / (width * height), value, fromTop: texture.flipY };
}

function coloursOf({ width, height, channels, value }: Equirectangular): Float32Array {
    return Float32Array.from({ length: 3 * width * height }, (_, i) => value(Math.floor(i / 3) * channels + (i % 3)));
}

function textureOf({ width, height, value }: Equirectangular, before: DataTexture): DataTexture {
    const data = Float32Array.from({ length: 4 * width * height }, (_, i) => (i % 4 < 3 ? value(3 * (i >> 2) + (i % 4)) : 1));
    const texture = new DataTexture(data, width, height, RGBAFormat, FloatType);
    texture.mapping = EquirectangularReflectionMapping;
    texture.magFilter = texture.minFilter = LinearFilter;
    texture.flipY = before.flipY;
    texture.needsUpdate = true;
    return texture;
}

/** The columns of a matrix without its scale. */
function rotationOf(matrix: Matrix4): number[] {
    const e = matrix.elements;
    return [0, 4, 8].flatMap((c) => {
        const length = Math.hypot(e[c], e[c + 1], e[c + 2]);
        return [e[c] / length, e[c + 1] / length, e[c + 2] / length];
    });
}
