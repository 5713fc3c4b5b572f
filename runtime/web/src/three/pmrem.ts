// Light of textures that live on the GPU, as PMREMGenerator of three.js makes them: a cube, or (before 0.186) six faces
// of one in a plane picture, three in a row, two rows, below blurred ones. There each face has a border of one texel
// for filters, which belongs to its neighbours.
import {
    DataUtils,
    HalfFloatType,
    Mesh,
    NearestFilter,
    OrthographicCamera,
    PlaneGeometry,
    ShaderMaterial,
    WebGLRenderTarget,
    type CubeTexture,
    type Texture,
    type WebGLRenderer,
} from 'three';
import { PenumbraError } from '../error.js';
import { basis } from '../sh.js';

/** Six faces, [2 size, 3 size, 4] half floats: three in a row, the first row at the bottom. */
export interface CubeFaces {
    pixels: Uint16Array;
    size: number;
    /** Texels of the texture that each of them stands for, in a row. */
    stepSize: number;
    /** Texels of the texture at each side of a face that do not belong to it. */
    border: number;
}

const CUBE_UV = 306; // CubeUVReflectionMapping, which not all versions have
// The finest faces that are read: more texels tell no more of 25 numbers.
const FINEST = 256;

const VERTEX = 'void main() { gl_Position = vec4( position.xy, 0.0, 1.0 ); }';
// The mean of step x step texels. Directions are those of FACES.
const FRAGMENT = `
uniform int stepSize;
uniform int faceSize;
#ifdef PLANE
uniform sampler2D map;
#else
uniform samplerCube map;
uniform float flip;
vec3 direction( ivec2 texel ) {
    ivec2 corner = texel / faceSize;
    vec2 at = 2.0 * ( vec2( texel - corner * faceSize ) + 0.5 ) / float( faceSize ) - 1.0;
    int face = 3 * corner.y + corner.x;
    if ( face == 0 ) return vec3( 1.0, at.y, at.x );
    if ( face == 1 ) return vec3( - at.x, 1.0, - at.y );
    if ( face == 2 ) return vec3( - at.x, at.y, 1.0 );
    if ( face == 3 ) return vec3( - 1.0, at.y, - at.x );
    if ( face == 4 ) return vec3( - at.x, - 1.0, at.y );
    return vec3( at.x, at.y, - 1.0 );
}
#endif
vec4 radiance( ivec2 texel ) {
#ifdef PLANE
    return texelFetch( map, texel, 0 );
#else
    return textureLod( map, direction( texel ) * vec3( flip, 1.0, 1.0 ), 0.0 );
#endif
}
void main() {
    vec4 sum = vec4( 0.0 );
    for ( int y = 0; y < stepSize; ++y )
        for ( int x = 0; x < stepSize; ++x ) sum += radiance( ivec2( gl_FragCoord.xy ) * stepSize + ivec2( x, y ) );
    gl_FragColor = sum / float( stepSize * stepSize );
}`;

function faceSizeOf(texture: Texture): number {
    const { image } = texture as { image: { width?: number; height?: number }[] & { height?: number } };
    const isCube = (texture as CubeTexture).isCubeTexture;
    const size = isCube ? image[0]?.width : (texture.mapping as number) === CUBE_UV ? image.height! / 4 : undefined;
    if (!(size && size >= 4)) throw new PenumbraError('UNSUPPORTED', 'the texture is neither a cube nor one that PMREMGenerator made');
    return size;
}

/** Reads the faces of such a texture. */
export function readFaces(renderer: WebGLRenderer, texture: Texture): CubeFaces {
    const faceSize = faceSizeOf(texture);
    const isCube = (texture as CubeTexture).isCubeTexture === true;
    const stepSize = Math.max(1, Math.round(faceSize / FINEST));
    const size = Math.floor(faceSize / stepSize);
    const target = new WebGLRenderTarget(3 * size, 2 * size, { type: HalfFloatType, minFilter: NearestFilter, magFilter: NearestFilter });
    const flip = texture.isRenderTargetTexture ? 1 : -1; // files have cubes seen from outside
    const uniforms = { map: { value: texture }, stepSize: { value: stepSize }, faceSize: { value: faceSize }, flip: { value: flip } };
    const defines: Record<string, string> = isCube ? {} : { PLANE: '' };
    const material = new ShaderMaterial({ uniforms, defines, vertexShader: VERTEX, fragmentShader: FRAGMENT, depthTest: false });
    const quad = new Mesh(new PlaneGeometry(2, 2), material);
    quad.frustumCulled = false;
    const before = renderer.getRenderTarget();
    renderer.setRenderTarget(target);
    renderer.render(quad, new OrthographicCamera());
    renderer.setRenderTarget(before);
    const pixels = new Uint16Array(4 * 6 * size * size);
    renderer.readRenderTargetPixels(target, 0, 0, 3 * size, 2 * size, pixels);
    for (const one of [target, material, quad.geometry]) one.dispose();
    return { pixels, size, stepSize, border: isCube ? 0 : 1 };
}

// Where each face looks at (u, v), which go from -1 to 1.
const FACES: ((u: number, v: number) => [number, number, number])[] = [
    (u, v) => [1, v, u],
    (u, v) => [-u, 1, -v],
    (u, v) => [-u, v, 1],
    (u, v) => [-1, v, -u],
    (u, v) => [-u, -1, v],
    (u, v) => [u, v, -1],
];

/** The light of the faces, [25, 3]. */
export function projectFaces({ pixels, size, stepSize, border }: CubeFaces): Float32Array {
    const sh = new Float64Array(75);
    const y = new Float64Array(25);
    // Where texels begin and end on a face, without its border.
    const inside = size * stepSize - 2 * border;
    const edge = (i: number) => Math.min(Math.max((2 * (i * stepSize - border)) / inside - 1, -1), 1);
    for (let face = 0; face < 6; ++face)
        for (let row = 0; row < size; ++row)
            for (let column = 0; column < size; ++column) {
                const area = (edge(column + 1) - edge(column)) * (edge(row + 1) - edge(row));
                const u = (edge(column) + edge(column + 1)) / 2;
                const v = (edge(row) + edge(row + 1)) / 2;
                const length = Math.hypot(u, v, 1);
                const [dx, dy, dz] = FACES[face](u, v);
                basis(dx / length, dy / length, dz / length, y);
                const texel = 4 * ((Math.floor(face / 3) * size + row) * 3 * size + (face % 3) * size + column);
                for (let k = 0; k < 3; ++k) {
                    const radiance = (area / length ** 3) * DataUtils.fromHalfFloat(pixels[texel + k]);
                    for (let i = 0; i < 25; ++i) sh[3 * i + k] += radiance * y[i];
                }
            }
    return Float32Array.from(sh);
}
