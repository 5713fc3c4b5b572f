import type { Material, WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';

/** A text that stands behind another in a shader of three.js. */
export interface Insertion {
    after: string;
    text: string;
}
export interface Patch {
    key: string;
    vertex: Insertion[];
    /** The last one is put before its mark instead of behind it: there, the light of the environment is complete. */
    fragment: Insertion[];
    uniforms: Record<string, { value: unknown }>;
}

const LIGHT_IS_COMPLETE = '#include <aomap_fragment>';

// `rgb` is what the environment's diffuse light loses. Specular light follows Lagarde's occlusion, as three's own AO.
export const DARKEN = `
    reflectedLight.indirectDiffuse *= 1.0 - penumbra.rgb;
#if defined( STANDARD )
    float penumbraFacing = saturate( dot( geometryNormal, geometryViewDir ) );
    reflectedLight.indirectSpecular *= saturate( pow( penumbraFacing + penumbra.a, exp2( - 16.0 * material.roughness - 1.0 ) ) - 1.0 + penumbra.a );
#endif
`;

// An attribute that a geometry lacks is (0, 0, 0, 1): all light. So other meshes may share the material. `centroid`: at
// edges of triangles an antialiased pixel would else take values from beyond, and small parts would get dark dots.
export const BY_VERTEX: Patch = {
    key: 'penumbra-vertex',
    vertex: [
        { after: '#include <common>', text: 'attribute vec4 penumbraLoss;\ncentroid varying vec4 vPenumbraLoss;' },
        { after: '#include <begin_vertex>', text: 'vPenumbraLoss = penumbraLoss;' },
    ],
    fragment: [
        { after: '#include <common>', text: 'centroid varying vec4 vPenumbraLoss;' },
        { after: LIGHT_IS_COMPLETE, text: `{ vec4 penumbra = vPenumbraLoss;${DARKEN}}` },
    ],
    uniforms: {},
};

function inserted(source: string, insertions: Insertion[]): string {
    for (const { after, text } of insertions) {
        const both = after === LIGHT_IS_COMPLETE ? `${text}\n${after}` : `${after}\n${text}`;
        source = source.replace(after, () => both);
    }
    return source;
}

type Compile = (shader: WebGLProgramParametersWithUniforms, renderer: WebGLRenderer) => void;

/** A patch of one material, for as many as asked for it. */
class Patched {
    users = 0;
    private readonly before: { compile: Compile; cacheKey: () => string };
    private readonly compile: Compile;
    private readonly cacheKey: () => string;

    constructor(
        private readonly material: Material,
        readonly patch: Patch,
    ) {
        const before = { compile: material.onBeforeCompile as Compile, cacheKey: material.customProgramCacheKey };
        this.before = before;
        this.compile = (shader, renderer) => {
            before.compile.call(material, shader, renderer);
            if (this.users === 0) return;
            shader.vertexShader = inserted(shader.vertexShader, patch.vertex);
            shader.fragmentShader = inserted(shader.fragmentShader, patch.fragment);
            Object.assign(shader.uniforms, patch.uniforms);
        };
        // Without a key of its own three.js would take the program of another material.
        this.cacheKey = () => (this.users > 0 ? `${patch.key} ` : '') + before.cacheKey.call(material);
        material.onBeforeCompile = this.compile;
        material.customProgramCacheKey = this.cacheKey;
    }
    /** Puts back what was there before, unless somebody else has put something over it. */
    unwrap(): boolean {
        const { material } = this;
        if (material.onBeforeCompile !== this.compile || material.customProgramCacheKey !== this.cacheKey) return false;
        material.onBeforeCompile = this.before.compile;
        material.customProgramCacheKey = this.before.cacheKey;
        return true;
    }
}

/** Patches of each material, the last one outermost. */
const patches = new WeakMap<Material, Patched[]>();

/** Adds to what a material does. Its own onBeforeCompile runs first. Returns what undoes it. */
export function patchMaterial(material: Material, patch: Patch): () => void {
    const all = patches.get(material) ?? [];
    patches.set(material, all);
    let patched = all.find((one) => one.patch.key === patch.key);
    if (!patched) all.push((patched = new Patched(material, patch)));
    if (++patched.users === 1) material.needsUpdate = true;
    return () => {
        if (--patched.users > 0) return;
        material.needsUpdate = true;
        while (all.length > 0 && all[all.length - 1].users === 0 && all[all.length - 1].unwrap()) all.pop();
    };
}
