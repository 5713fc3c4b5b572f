import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
import { PenumbraEnvironment } from 'penumbra-player/three';
import { bytesOf } from './load';

const TARGET = new THREE.Vector3(0, 0.9, 0);
const GROUND_RADIUS = 2.2;

export interface Sky {
    map: THREE.Texture;
    environment: PenumbraEnvironment;
}

/** A disc that fades out, so that the picture of the sky takes over. */
function makeGround(): THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial> {
    const canvas = document.createElement('canvas');
    canvas.width = canvas.height = 256;
    const paint = canvas.getContext('2d')!;
    const fade = paint.createRadialGradient(128, 128, 30, 128, 128, 128);
    fade.addColorStop(0, '#fff');
    fade.addColorStop(1, '#000');
    paint.fillStyle = fade;
    paint.fillRect(0, 0, 256, 256);
    const material = new THREE.MeshStandardMaterial({
        color: 0xb8b2a8, roughness: 0.9, alphaMap: new THREE.CanvasTexture(canvas), transparent: true, depthWrite: false,
    });
    const geometry = new THREE.CircleGeometry(GROUND_RADIUS, 96).rotateX(-Math.PI / 2);
    const ground = new THREE.Mesh(geometry, material);
    ground.receiveShadow = true;
    return ground;
}

function makeSun(): THREE.DirectionalLight {
    const sun = new THREE.DirectionalLight(0xfff0d8, 2.4);
    sun.castShadow = true;
    sun.shadow.mapSize.set(1024, 1024);
    sun.shadow.radius = 3;
    sun.shadow.normalBias = 0.02;
    Object.assign(sun.shadow.camera, { left: -1.6, right: 1.6, top: 1.6, bottom: -1.6, near: 0.5, far: 9 });
    sun.target.position.copy(TARGET);
    return sun;
}

/** The surroundings of the character: ground, sky, sun and a camera that fingers move. */
export class Stage {
    readonly renderer: THREE.WebGLRenderer;
    readonly scene = new THREE.Scene();
    readonly camera = new THREE.PerspectiveCamera(30, 1, 0.1, 60);
    readonly ground = makeGround();
    readonly sun = makeSun();
    private readonly controls: OrbitControls;
    private readonly skies = new Map<string, Promise<Sky>>();
    private sky: Sky | undefined;

    constructor(private readonly canvas: HTMLCanvasElement) {
        this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
        this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        this.renderer.toneMapping = THREE.AgXToneMapping;
        this.renderer.toneMappingExposure = 1.15;
        this.renderer.shadowMap.enabled = true;
        this.scene.backgroundBlurriness = 0.45;
        this.scene.backgroundIntensity = 0.8;
        this.scene.add(this.ground, this.sun, this.sun.target);
        this.controls = new OrbitControls(this.camera, canvas);
        this.controls.target.copy(TARGET);
        Object.assign(this.controls, { enableDamping: true, enablePan: false, minDistance: 1.2, maxDistance: 9, maxPolarAngle: 1.62 });
        this.resize();
    }

    /** Loads a sky once. A failure is not kept. */
    loadSky(name: string): Promise<Sky> {
        const known = this.skies.get(name);
        if (known) return known;
        const sky = this.makeSky(name);
        this.skies.set(name, sky);
        sky.catch(() => this.skies.delete(name));
        return sky;
    }
    /** Lights the scene by a sky. */
    useSky(sky: Sky): void {
        this.sky = sky;
        this.scene.environment = this.scene.background = sky.map;
    }

    /** Turns the sky, and the sun with it. */
    turn(angle: number): void {
        this.scene.environmentRotation.y = this.scene.backgroundRotation.y = angle;
        this.sky?.environment.setRotation(new THREE.Matrix4().makeRotationY(angle));
        this.sun.position.set(2.2, 3.4, 1.9).applyAxisAngle(THREE.Object3D.DEFAULT_UP, angle).add(TARGET);
    }

    /** Fits the picture into the window; the whole character is seen in tall windows, too, above the panel. */
    resize(): void {
        const { clientWidth: width, clientHeight: height } = this.canvas;
        this.renderer.setSize(width, height, false);
        this.camera.aspect = width / height;
        const narrow = width <= 640;
        this.camera.setViewOffset(width, height, narrow ? 0 : width > 1000 ? 60 : 110, narrow ? height * 0.11 : 0, width, height);
        const distance = narrow ? Math.max(5.2, 3.1 / this.camera.aspect) : 4.3;
        const offset = this.camera.position.clone().sub(TARGET);
        if (offset.lengthSq() < 1.1) offset.set(0.62, 0.24, 0.86);
        this.camera.position.copy(TARGET).add(offset.setLength(distance));
        this.camera.updateProjectionMatrix();
    }

    /** Where the character stands in the window, as a share of its width. */
    get middle(): number {
        this.controls.update();
        this.camera.updateMatrixWorld();
        return 0.5 + 0.5 * TARGET.clone().project(this.camera).x;
    }

    /** Draws the part of the window between two shares of its width. */
    draw(from = 0, to = 1): void {
        if (from === 0) this.controls.update(); // once a frame: it slows down at each call
        const { clientWidth: width, clientHeight: height } = this.canvas;
        this.renderer.setScissorTest(from > 0 || to < 1);
        this.renderer.setScissor(from * width, 0, (to - from) * width, height);
        this.renderer.render(this.scene, this.camera);
    }
    private async makeSky(name: string): Promise<Sky> {
        const { data, width, height } = new EXRLoader().parse(await bytesOf(name));
        const texture = new THREE.DataTexture(data, width, height, THREE.RGBAFormat, THREE.HalfFloatType);
        texture.mapping = THREE.EquirectangularReflectionMapping;
        texture.magFilter = texture.minFilter = THREE.LinearFilter;
        texture.needsUpdate = true;
        const environment = PenumbraEnvironment.fromEquirectangular(texture);
        const generator = new THREE.PMREMGenerator(this.renderer);
        const map = generator.fromEquirectangular(texture).texture;
        generator.dispose();
        texture.dispose();
        return { map, environment };
    }
}
