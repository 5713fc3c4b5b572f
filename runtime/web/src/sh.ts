// Real orthonormal spherical harmonics of order 5 with the Condon-Shortley sign, index l(l+1)+m, polar axis z. Lights
// have three colours a coefficient: [25, 3].

const COUNT = 25;
// Integrals of band l times max(cos, 0): what a light without obstacles does to a surface.
const COSINE = [Math.PI, (2 * Math.PI) / 3, Math.PI / 4, 0, -Math.PI / 24];
const BAND = Array.from({ length: COUNT }, (_, i) => Math.floor(Math.sqrt(i)));

/** Values of the functions at a unit direction: all 25, or at least those of `order`. */
export function basis(x: number, y: number, z: number, out: Float64Array, order = 5): void {
    const zz = z * z;
    out[0] = 0.28209479177387814;
    out[1] = -0.4886025119029199 * y;
    out[2] = 0.4886025119029199 * z;
    out[3] = -0.4886025119029199 * x;
    out[4] = 1.0925484305920792 * x * y;
    out[5] = -1.0925484305920792 * y * z;
    out[6] = 0.31539156525252005 * (3 * zz - 1);
    out[7] = -1.0925484305920792 * x * z;
    out[8] = 0.5462742152960396 * (x * x - y * y);
    if (order <= 3) return;
    out[9] = -0.5900435899266435 * y * (3 * x * x - y * y);
    out[10] = 2.890611442640554 * x * y * z;
    out[11] = -0.4570457994644658 * y * (5 * zz - 1);
    out[12] = 0.3731763325901154 * z * (5 * zz - 3);
    out[13] = -0.4570457994644658 * x * (5 * zz - 1);
    out[14] = 1.445305721320277 * z * (x * x - y * y);
    out[15] = -0.5900435899266435 * x * (x * x - 3 * y * y);
    out[16] = 2.5033429417967046 * x * y * (x * x - y * y);
    out[17] = -1.7701307697799304 * y * z * (3 * x * x - y * y);
    out[18] = 0.9461746957575601 * x * y * (7 * zz - 1);
    out[19] = -0.6690465435572892 * y * z * (7 * zz - 3);
    out[20] = 0.10578554691520431 * (35 * zz * zz - 30 * zz + 3);
    out[21] = -0.6690465435572892 * x * z * (7 * zz - 3);
    out[22] = 0.47308734787878004 * (x * x - y * y) * (7 * zz - 1);
    out[23] = -1.7701307697799304 * x * z * (x * x - 3 * y * y);
    out[24] = 0.6258357354491761 * (x * x * (x * x - 3 * y * y) - y * y * (3 * x * x - y * y));
}

/** A picture of all directions as three.js has them: u from atan2(z, x), the row at v = 0 looks down. */
export interface Equirectangular {
    width: number;
    height: number;
    /** Numbers a pixel; the first three are linear radiance. */
    channels: number;
    /** The value at an index of the picture's array. */
    value: (index: number) => number;
    /** Whether the first row looks up. */
    fromTop: boolean;
}

export function projectPicture(picture: Equirectangular): Float32Array {
    const { width, height, channels, value } = picture;
    const sh = new Float64Array(3 * COUNT);
    const y = new Float64Array(COUNT);
    for (let row = 0; row < height; ++row) {
        const up = (((row + 0.5) / height - 0.5) * Math.PI) * (picture.fromTop ? -1 : 1);
        const weight = (Math.PI / height) * ((2 * Math.PI) / width) * Math.cos(up);
        for (let column = 0; column < width; ++column) {
            const around = ((column + 0.5) / width - 0.5) * 2 * Math.PI;
            basis(Math.cos(up) * Math.cos(around), Math.sin(up), Math.cos(up) * Math.sin(around), y);
            const at = (row * width + column) * channels;
            for (let k = 0; k < 3; ++k) {
                const radiance = weight * value(at + k);
                for (let i = 0; i < COUNT; ++i) sh[3 * i + k] += radiance * y[i];
            }
        }
    }
    return Float32Array.from(sh);
}

/** A light from a single direction. */
export interface Sun {
    /** Unit, towards the sun. */
    direction: number[];
    /** At normal incidence, linear Rec.709. */
    irradiance: number[];
}

// A sun takes no more of the sky than a disc of this radius, and it has at least this share of all light.
const SUN_RADIUS = (3 * Math.PI) / 180;
const SUN_SHARE = 0.05;

const luminance = (r: number, g: number, b: number) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

/** Moves suns out of a picture, [width x height, 3] in the order of its pixels, which is changed: each disc around a
 * brightest pixel gets the light of the ring around it, and the sun has the rest. Answers `most` suns or fewer. */
export function takeSuns(picture: Equirectangular, pixels: Float32Array, most: number): Sun[] {
    const suns: Sun[] = [];
    while (suns.length < most) {
        const sun = takeSun(picture, pixels);
        if (!sun) break;
        suns.push(sun);
    }
    return suns;
}

/** Unit direction of each pixel and its solid angle, [width x height, 4]. */
function pixelDirections({ width, height, fromTop }: Equirectangular): Float32Array {
    const out = new Float32Array(4 * width * height);
    for (let row = 0, at = 0; row < height; ++row) {
        const up = (((row + 0.5) / height - 0.5) * Math.PI) * (fromTop ? -1 : 1);
        const solid = (Math.PI / height) * ((2 * Math.PI) / width) * Math.cos(up);
        for (let column = 0; column < width; ++column, at += 4) {
            const around = ((column + 0.5) / width - 0.5) * 2 * Math.PI;
            out.set([Math.cos(up) * Math.cos(around), Math.sin(up), Math.cos(up) * Math.sin(around), solid], at);
        }
    }
    return out;
}

function takeSun(picture: Equirectangular, pixels: Float32Array): Sun | undefined {
    const directions = pixelDirections(picture);
    const count = picture.width * picture.height;
    // 1. The brightest pixel, and all light there is.
    let [brightest, peak, all] = [0, -1, 0];
    for (let i = 0; i < count; ++i) {
        const light = luminance(pixels[3 * i], pixels[3 * i + 1], pixels[3 * i + 2]);
        all += light * directions[4 * i + 3];
        if (light > peak) [brightest, peak] = [i, light];
    }
    // 2. The disc around it, and the mean of a ring of twice its radius.
    const radius = Math.max(SUN_RADIUS, (1.5 * Math.PI) / picture.height);
    const middle = directions.slice(4 * brightest, 4 * brightest + 3);
    const disc: number[] = [];
    const ring = [0, 0, 0];
    let ringSolid = 0;
    for (let i = 0; i < count; ++i) {
        const cosine = directions[4 * i] * middle[0] + directions[4 * i + 1] * middle[1] + directions[4 * i + 2] * middle[2];
        if (cosine < Math.cos(2 * radius)) continue;
        if (cosine >= Math.cos(radius)) disc.push(i);
        else {
            for (let k = 0; k < 3; ++k) ring[k] += pixels[3 * i + k] * directions[4 * i + 3];
            ringSolid += directions[4 * i + 3];
        }
    }
    // 3. What the disc has beyond the ring is the sun, if it is enough.
    const irradiance = [0, 0, 0];
    const direction = [0, 0, 0];
    for (const i of disc)
        for (let k = 0; k < 3; ++k) {
            const beyond = Math.max(pixels[3 * i + k] - ring[k] / ringSolid, 0) * directions[4 * i + 3];
            irradiance[k] += beyond;
            for (let axis = 0; axis < 3; ++axis) direction[axis] += beyond * directions[4 * i + axis];
        }
    const found = luminance(irradiance[0], irradiance[1], irradiance[2]);
    if (!(found > 0 && found >= SUN_SHARE * all)) return undefined; // nothing is left in a black picture
    for (const i of disc) for (let k = 0; k < 3; ++k) pixels[3 * i + k] = Math.min(pixels[3 * i + k], ring[k] / ringSolid);
    const length = Math.hypot(...direction);
    return { direction: direction.map((x) => x / length), irradiance };
}

// Five places of Gauss and nine angles integrate the product of two functions of order 5 exactly.
const GAUSS = [0, 0.5384693101056831, -0.5384693101056831, 0.906179845938664, -0.906179845938664];
const GAUSS_WEIGHT = [0.5688888888888889, 0.47862867049936647, 0.47862867049936647, 0.23692688505618908, 0.23692688505618908];
const ANGLES = 9;

/** Turns a light: L'(s) = L(R^T s), where `rotation` has the columns of R. */
export function rotateLight(sh: ArrayLike<number>, rotation: ArrayLike<number>): Float32Array {
    const out = new Float64Array(3 * COUNT);
    const here = new Float64Array(COUNT);
    const there = new Float64Array(COUNT);
    for (let node = 0; node < 5; ++node)
        for (let angle = 0; angle < ANGLES; ++angle) {
            const around = (2 * Math.PI * angle) / ANGLES;
            const ring = Math.sqrt(1 - GAUSS[node] ** 2);
            const s = [ring * Math.cos(around), ring * Math.sin(around), GAUSS[node]];
            const from = [0, 1, 2].map((c) => rotation[3 * c] * s[0] + rotation[3 * c + 1] * s[1] + rotation[3 * c + 2] * s[2]);
            basis(s[0], s[1], s[2], here);
            basis(from[0], from[1], from[2], there);
            const weight = (GAUSS_WEIGHT[node] * 2 * Math.PI) / ANGLES;
            for (let k = 0; k < 3; ++k) {
                let radiance = 0;
                for (let i = 0; i < COUNT; ++i) radiance += sh[3 * i + k] * there[i];
                for (let i = 0; i < COUNT; ++i) out[3 * i + k] += weight * radiance * here[i];
            }
        }
    return Float32Array.from(out);
}

/** Irradiance [count, 3] of surfaces with these normals where nothing hides the light, of which `order` bands count. */
export function openIrradiance(sh: ArrayLike<number>, normals: ArrayLike<number>, out: Float32Array, order = 5): void {
    const count = order * order;
    const y = new Float64Array(COUNT);
    const folded = Float64Array.from({ length: 3 * COUNT }, (_, i) => COSINE[BAND[Math.floor(i / 3)]] * sh[i]);
    for (let at = 0; at < normals.length; at += 3) {
        basis(normals[at], normals[at + 1], normals[at + 2], y, order);
        let [r, g, b] = [0, 0, 0];
        for (let i = 0; i < count; ++i) {
            r += y[i] * folded[3 * i];
            g += y[i] * folded[3 * i + 1];
            b += y[i] * folded[3 * i + 2];
        }
        out[at] = r;
        out[at + 1] = g;
        out[at + 2] = b;
    }
}

/** Irradiance [count, 3] of surfaces with this transfer [count, order^2]. */
export function visibleIrradiance(sh: ArrayLike<number>, transfer: Float32Array, out: Float32Array, order = 5): void {
    const count = order * order;
    for (let at = 0, t = 0; t < transfer.length; at += 3) {
        let [r, g, b] = [0, 0, 0];
        for (let i = 0; i < 3 * count; i += 3, ++t) {
            const share = transfer[t];
            r += share * sh[i];
            g += share * sh[i + 1];
            b += share * sh[i + 2];
        }
        out[at] = r;
        out[at + 1] = g;
        out[at + 2] = b;
    }
}
