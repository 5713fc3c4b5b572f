import { ClampToEdgeWrapping, DataTexture, DataUtils, HalfFloatType, LinearFilter, RGBAFormat, Vector3, type Material, type Mesh } from 'three';
import { Scene, ScenePoints, type Runtime } from '../core.js';
import { openIrradiance } from '../sh.js';
import type { PenumbraCharacter } from './character.js';
import type { PenumbraEnvironment } from './environment.js';
import { DARKEN, patchMaterial, type Patch } from './materials.js';

export interface PenumbraGroundOptions {
    environment?: PenumbraEnvironment;
    /** Points a side of each square (default 33). */
    points?: number;
    /** Half of the side of the square around each character, in metres (default 2). */
    radius?: number;
    /** Height of the ground in the world (default: that of the mesh's origin). */
    height?: number;
    /** Frames from one update of a square to its next (default 2). */
    every?: number;
}

let counter = 0;

/** The squares of a ground: a picture with one below the other, and where they lie. */
export interface Squares {
    map: DataTexture;
    /** The middle of each in x and z, and half of its side. */
    areas: Vector3[];
    /** Texels of each, in a row. */
    side: number;
}

function patchOf({ map, areas, side }: Squares): Patch {
    const id = counter++;
    const [picture, places, world] = [`penumbraMap${id}`, `penumbraAreas${id}`, `vPenumbraWorld${id}`];
    const count = areas.length;
    const least = (1 / side - 1).toFixed(8); // the middle of the outermost texel: beyond it lies another square
    return {
        key: `penumbra-ground-${id}`,
        vertex: [
            { after: '#include <common>', text: `varying vec2 ${world};` },
            { after: '#include <project_vertex>', text: `${world} = ( modelMatrix * vec4( transformed, 1.0 ) ).xz;` },
        ],
        fragment: [
            {
                after: '#include <common>',
                text: `varying vec2 ${world};\nuniform sampler2D ${picture};\nuniform vec3 ${places}[ ${count} ];`,
            },
            {
                after: '#include <aomap_fragment>',
                // Each square has what all characters hide, so that where squares lie over one another their mean
                // counts. Nothing is lost at the border of a square and beyond.
                text: `{
    vec4 penumbra = vec4( 0.0 );
    float penumbraWeight = 0.0;
    for ( int i = 0; i < ${count}; ++i ) {
        vec2 at = ( ${world} - ${places}[ i ].xy ) / ${places}[ i ].z;
        float inside = saturate( 4.0 - 4.0 * max( abs( at.x ), abs( at.y ) ) );
        vec2 texel = 0.5 + 0.5 * clamp( at, ${least}, - ( ${least} ) );
        vec4 lost = texture2D( ${picture}, vec2( texel.x, ( texel.y + float( i ) ) / ${count}.0 ) );
        penumbra += inside * vec4( lost.rgb, 1.0 - lost.a );
        penumbraWeight += inside;
    }
    penumbra /= max( penumbraWeight, 1.0 );
    penumbra.a = 1.0 - penumbra.a;${DARKEN}}`,
            },
        ],
        uniforms: { [picture]: { value: map }, [places]: { value: areas } },
    };
}

const up = [0, 1, 0];

/** Contact shadows of characters on a level ground: a small picture around each of them of what all of them hide. */
export class PenumbraGround {
    strength = 1;
    private readonly scene: Scene;
    private readonly grid: ScenePoints;
    private readonly squares: Squares;
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
        const normals = this.positions.map((_, i) => up[i % 3]);
        this.scene = new Scene(runtime, characters.map((one) => one.asset));
        this.grid = new ScenePoints(runtime, this.positions, normals);
        this.squares = makeSquares(this.side, Math.max(characters.length, 1));
        this.undo = this.patch(mesh, this.squares);
    }

    setEnvironment(environment: PenumbraEnvironment | undefined): void {
        this.environment = environment;
    }

    /** Computes the shadows where the characters are now: once a frame, after their own updates. At first all squares
     * are new, later they take turns. */
    update(): void {
        const { frame, characters } = this;
        const every = this.options.every ?? 2;
        const isDue = (i: number) => frame === 0 || (frame + i) % every === 0;
        ++this.frame;
        if (!characters.some((_, i) => isDue(i))) return;
        characters.forEach((one, i) => this.scene.setCaster(i, one.character, one.place));
        characters.forEach((one, i) => {
            if (!isDue(i)) return;
            this.moveGrid(new Vector3().setFromMatrixPosition(one.bodyWorld), this.squares.areas[i]);
            this.fillSquare(i);
        });
        this.squares.map.needsUpdate = true;
    }

    /** Gives memory back, and the mesh its material. A second call does nothing. */
    dispose(): void {
        for (const undo of this.undo.splice(0)) undo();
        this.scene.dispose();
        this.grid.dispose();
        this.squares.map.dispose();
    }

    /** Makes the mesh's materials use the squares. Answers what undoes it. */
    protected patch(mesh: Mesh, squares: Squares): (() => void)[] {
        const patch = patchOf(squares);
        return ([] as Material[]).concat(mesh.material).map((material) => patchMaterial(material, patch));
    }

    // Points lie in the middles of texels.
    private moveGrid(center: Vector3, area: Vector3): void {
        const { side, radius } = this;
        const height = this.options.height ?? this.mesh.getWorldPosition(new Vector3()).y;
        area.set(center.x, center.z, radius);
        for (let row = 0; row < side; ++row)
            for (let column = 0; column < side; ++column) {
                const at = 3 * (row * side + column);
                this.positions[at] = center.x + radius * ((2 * column + 1) / side - 1);
                this.positions[at + 1] = height;
                this.positions[at + 2] = center.z + radius * ((2 * row + 1) / side - 1);
            }
        this.grid.move(this.positions);
    }
    private fillSquare(square: number): void {
        const count = this.side ** 2;
        const out = (this.squares.map.image.data as Uint16Array).subarray(4 * square * count, 4 * (square + 1) * count);
        const light = this.environment?.world;
        const open = new Float32Array(3);
        if (light) openIrradiance(light, up, open);
        const colours = light ? this.grid.irradiance(this.scene, 5, light).slice() : undefined;
        const ambient = this.grid.ambient(this.scene);
        for (let i = 0; i < count; ++i) {
            for (let k = 0; k < 3; ++k) {
                const share = colours && open[k] > 0 ? colours[3 * i + k] / open[k] : ambient[i];
                out[4 * i + k] = DataUtils.toHalfFloat(this.strength * (1 - Math.min(Math.max(share, 0), 1)));
            }
            out[4 * i + 3] = DataUtils.toHalfFloat(1 - this.strength * (1 - ambient[i]));
        }
    }
}

/** Squares that nothing is drawn into yet: they lie far away. */
function makeSquares(side: number, count: number): Squares {
    const map = new DataTexture(new Uint16Array(4 * count * side ** 2), side, count * side, RGBAFormat, HalfFloatType);
    map.magFilter = map.minFilter = LinearFilter;
    map.wrapS = map.wrapT = ClampToEdgeWrapping;
    map.needsUpdate = true;
    return { map, areas: Array.from({ length: count }, () => new Vector3(1e9, 1e9, 1)), side };
}
