import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import type { Runtime } from 'penumbra-player';
import { PenumbraCharacter, PenumbraGround, PenumbraLoader, assetOf, type PenumbraEnvironment } from 'penumbra-player/three';
import { bytesOf } from './load';
import { Truth } from './truth';

export type Shadow = 'off' | 'occlusion' | 'colour';

/** Bands of the light that count: the truth of the page has as many. */
const ORDER = 4;

/** The character, its clips, and shadows of it: computed, or those that were traced. */
export class Actor {
    readonly character: PenumbraCharacter;
    readonly ground: PenumbraGround;
    /** How long the shadows of the last frame took, in milliseconds. */
    ms = 0;
    private readonly mixer: THREE.AnimationMixer;
    private readonly actions = new Map<string, THREE.AnimationAction>();
    private readonly traced: Float32Array;
    private clip = '';
    private environment: PenumbraEnvironment | undefined;

    private constructor(
        runtime: Runtime,
        floor: THREE.Mesh,
        gltf: { scene: THREE.Group; userData: Record<string, unknown> },
        readonly truth: Truth,
    ) {
        const asset = gltf.userData.penumbra as NonNullable<ReturnType<typeof assetOf>>;
        gltf.scene.traverse((object) => {
            object.castShadow = object.receiveShadow = true;
            object.frustumCulled = false;
        });
        this.character = new PenumbraCharacter(asset, gltf.scene, { order: ORDER });
        this.ground = new PenumbraGround(runtime, floor, [this.character], { radius: 1.6 });
        this.mixer = new THREE.AnimationMixer(gltf.scene);
        this.traced = new Float32Array(4 * asset.vertexCount);
    }

    static async load(runtime: Runtime, floor: THREE.Mesh, clips: Record<string, string>): Promise<Actor> {
        const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
        loader.register((parser) => new PenumbraLoader(parser, runtime));
        const gltf = await loader.parseAsync(await bytesOf('man.glb.gz'), '');
        const truth = await Truth.load('walk.truth.gz', assetOf(gltf)!);
        const actor = new Actor(runtime, floor, gltf, truth);
        for (const [name, file] of Object.entries(clips)) {
            const { animations } = await loader.parseAsync(await bytesOf(file), '');
            actor.actions.set(name, actor.mixer.clipAction(animations[0]));
        }
        return actor;
    }

    get root(): THREE.Object3D {
        return this.character.root;
    }
    get time(): number {
        return this.actions.get(this.clip)?.time ?? 0;
    }
    play(clip: string): void {
        if (clip === this.clip) return;
        const next = this.actions.get(clip)!;
        const before = this.actions.get(this.clip);
        this.clip = clip;
        next.reset().play();
        if (before) before.crossFadeTo(next, 0.3, false);
    }
    /** One clip alone at one time. */
    pose(clip: string, seconds: number): void {
        this.mixer.stopAllAction();
        this.clip = clip;
        this.actions.get(clip)!.reset().play();
        this.mixer.setTime(seconds);
    }
    advance(seconds: number): void {
        this.mixer.update(seconds);
    }

    setShadow(shadow: Shadow, environment: PenumbraEnvironment): void {
        this.environment = shadow === 'colour' ? environment : undefined;
        this.character.setEnvironment(this.environment);
        this.ground.setEnvironment(this.environment);
        this.character.strength = this.ground.strength = shadow === 'off' ? 0 : 1;
    }
    /** Shadows as the model computes them. */
    compute(): void {
        const start = performance.now();
        this.character.update();
        this.ground.update();
        this.ms += 0.1 * (performance.now() - start - this.ms);
    }
    /** Shadows as rays found them, for the pose that compute() was called for. */
    showTruth(): void {
        const light = this.environment?.inFrameOf(this.root.matrixWorld);
        this.truth.loss(this.time, this.character.character.normals, light, this.traced);
        this.character.apply(this.traced);
    }
}
