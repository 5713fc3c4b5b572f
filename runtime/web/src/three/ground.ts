import { ClampToEdgeWrapping, DataTexture, DataUtils, HalfFloatType, LinearFilter, RGBAFormat, Vector3, type Material, type Mesh } from 'three';
import { Scene, ScenePoints, type Place, type Runtime } from '../core.js';
import { openIrradiance } from '../sh.js';
import type { PenumbraCharacter } from './character.js';
import type { PenumbraEnvironment } from './environment.js';
import { DARKEN, patchMaterial, type Patch } from './materials.js';

export interface PenumbraGroundOptions {
    environment?: PenumbraEnvironment;
    /** Points a side (default 33). */
    points?: number;
    /** Half of the side of the square around the characters, in metres (default 2). */
    radius?: number;
    /** Height of the ground in the world (default: that of the mesh's origin). */
    height?: number;
    /** Frames from one update to the next (default 2). */
    every?: number;
}

let counter = 0;

function patchOf(texture: DataTexture, area: { value: Vector3 }): Patch {
    const id = counter++;
    const [map, place, world] = [`penumbraMap${id}`, `penumbraArea${id}`, `vPenumbraWorld${id}`];
    return {
        key: `penumbra-ground-${id}`,
        vertex: [
            { after: '#include <common>', text: `varying vec2 ${world};` },
            { after: '#include <project_vertex>', text: `${world} = ( modelMatrix * vec4( transformed, 1.0 ) ).xz;` },
        ],
        fragment: [
            { after: '#include <common>', text: `varying vec2 ${world};\nuniform sampler2D ${map};\nuniform vec3 ${place};` },
            {
                after: '#include <aomap_fragment>',
                // Nothing is lost at the border of the square and beyond.
                text: `{
    vec2 penumbraAt = ( ${world} - ${place}.xy ) / ${place}.z;
    vec4 penumbra = texture2D( ${map}, 0.5 + 0.5 * penumbraAt );
    float penumbraInside = saturate( 4.0 - 4.0 * max( abs( penumbraAt.x ), abs( penumbraAt.y ) ) );
    penumbra.rgb *= penumbraInside;
    penumbra.a = mix( 1.0, penumbra.a, penumbraInside );${DARKEN}}`,
            },
        ],
        uniforms: { [map]: { value: texture }, [place]: area },
    };
}

/** Contact shadows of characters on a level ground: a small picture around them of what they hide. */
export class PenumbraGround {
    strength = 1;
    private readonly scene: Scene;
    private readonly grid: ScenePoints;
    private readonly texture: DataTexture;
    /** Middle of the square in x and z, and half of its side. */
    private readonly area = new Vector3();
    private readonly undo: (() => void)[];
    private readonly positions: Float32Array;
    private readonly side: number;
    private readonly radius: number;
    private frame = 0;
    private environment: PenumbraEnvironment | undefined;

    constructor(
        runtime: Runtime,
        readonly mesh: Mesh,
        readonly characters: readonly PenumbraCharacter[],
        private readonly options: PenumbraGroundOptions = {},
    ) {
        this.environment = options.environment;
        this.side = options.points ?? 33;
        this.radius = options.radius ?? 2;
        this.positions = new Float32Array(3 * this.side ** 2);
        const up = this.positions.map((_, i) => (i % 3 === 1 ? 1 : 0));
        this.scene = new Scene(runtime, characters.map((one) => one.asset));
        this.grid = new ScenePoints(runtime, this.positions, up);
        this.texture = new DataTexture(new Uint16Array(4 * this.side ** 2), this.side, this.side, RGBAFormat, HalfFloatType);
        this.texture.magFilter = this.texture.minFilter = LinearFilter;
        this.texture.wrapS = this.texture.wrapT = ClampToEdgeWrapping;
        this.undo = this.patch(mesh, this.texture, this.area);
    }

    setEnvironment(environment: PenumbraEnvironment | undefined): void {
        this.environment = environment;
    }

    /** Computes the shadows where the characters are now: once a frame, after their own updates. */
    update(): void {
        if (this.frame++ % (this.options.every ?? 2) !== 0) return;
        const center = new Vector3();
        this.characters.forEach((one, i) => {
            this.scene.setCaster(i, one.character, placeOf(one));
            center.add(new Vector3().setFromMatrixPosition(one.bodyWorld).divideScalar(this.characters.length));
        });
        this.moveGrid(center);
        this.fillTexture();
    }

    /** Gives memory back, and the mesh its material. A second call does nothing. */
    dispose(): void {
        for (const undo of this.undo.splice(0)) undo();
        this.scene.dispose();
        this.grid.dispose();
        this.texture.dispose();
    }

    /** Makes the mesh's materials use the picture around `area`. Answers what undoes it. */
    protected patch(mesh: Mesh, texture: DataTexture, area: Vector3): (() => void)[] {
        const patch = patchOf(texture, { value: area });
        return ([] as Material[]).concat(mesh.material).map((material) => patchMaterial(material, patch));
    }

    // Points lie in the middles of texels.
    private moveGrid(center: Vector3): void {
        const { side, radius } = this;
        const height = this.options.height ?? this.mesh.getWorldPosition(new Vector3()).y;
        this.area.set(center.x, center.z, radius);
        for (let row = 0; row < side; ++row)
            for (let column = 0; column < side; ++column) {
                const at = 3 * (row * side + column);
                this.positions[at] = center.x + radius * ((2 * column + 1) / side - 1);
                this.positions[at + 1] = height;
                this.positions[at + 2] = center.z + radius * ((2 * row + 1) / side - 1);
            }
        this.grid.move(this.positions);
    }
    private fillTexture(): void {
        const out = this.texture.image.data as Uint16Array;
        const count = this.side ** 2;
        const light = this.environment?.world;
        const open = new Float32Array(3);
        if (light) openIrradiance(light, [0, 1, 0], open);
        const colours = light ? this.grid.irradiance(this.scene, 5, light).slice() : undefined;
        const ambient = this.grid.ambient(this.scene);
        for (let i = 0; i < count; ++i) {
            for (let k = 0; k < 3; ++k) {
                const share = colours && open[k] > 0 ? colours[3 * i + k] / open[k] : ambient[i];
                out[4 * i + k] = DataUtils.toHalfFloat(this.strength * (1 - Math.min(Math.max(share, 0), 1)));
            }
            out[4 * i + 3] = DataUtils.toHalfFloat(1 - this.strength * (1 - ambient[i]));
        }
        this.texture.needsUpdate = true;
    }
}

function placeOf(character: PenumbraCharacter): Place {
    const e = character.root.matrixWorld.elements;
    return [e[0], e[4], e[8], e[12], e[1], e[5], e[9], e[13], e[2], e[6], e[10], e[14]];
}
