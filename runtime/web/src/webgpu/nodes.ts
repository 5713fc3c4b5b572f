import {
    MeshLambertNodeMaterial,
    MeshPhongNodeMaterial,
    MeshPhysicalNodeMaterial,
    MeshStandardNodeMaterial,
    MeshToonNodeMaterial,
    type LightingModel,
    type Material,
    type Mesh,
    type NodeBuilder,
    type NodeMaterial,
} from 'three/webgpu';
import { normalView, positionViewDirection, roughness } from 'three/tsl';
import { PenumbraError } from '../error.js';

/** A node of TSL. Its methods are those of swizzles and arithmetic, for which types of three.js differ by version. */
// eslint-disable-next-line @typescript-eslint/no-explicit-any
export type Tsl = any;
/** The node (what each colour loses, E) where the patched material is drawn; undefined where it has none. */
export type LossNode = (builder: NodeBuilder) => Tsl | undefined;

const NODE_MATERIALS: Record<string, new () => NodeMaterial> = {
    MeshLambertMaterial: MeshLambertNodeMaterial,
    MeshPhongMaterial: MeshPhongNodeMaterial,
    MeshPhysicalMaterial: MeshPhysicalNodeMaterial,
    MeshStandardMaterial: MeshStandardNodeMaterial,
    MeshToonMaterial: MeshToonNodeMaterial,
};

/** The node material that the renderer itself would make of a material. */
function nodeMaterialOf(material: Material): NodeMaterial {
    if ((material as NodeMaterial).isNodeMaterial) return material as NodeMaterial;
    const type = NODE_MATERIALS[material.type];
    if (!type) throw new PenumbraError('UNSUPPORTED', `a ${material.type} has no light of the environment that could be darkened`);
    const node = new type();
    for (const key in material)
        if (key !== 'uuid') (node as unknown as Record<string, unknown>)[key] = (material as unknown as Record<string, unknown>)[key];
    return node;
}

/** Darkens what `model` found of the light of the environment, as materials.ts does for WebGLRenderer. */
function darken(builder: NodeBuilder, loss: Tsl, specular: boolean): void {
    const { reflectedLight } = (builder as Tsl).context as { reflectedLight: Record<string, Tsl> };
    reflectedLight.indirectDiffuse.mulAssign(loss.rgb.oneMinus());
    if (!specular) return;
    const e = loss.a;
    const facing = (normalView as Tsl).dot(positionViewDirection).clamp();
    const share = facing.add(e).pow((roughness as Tsl).mul(-16).sub(1).exp2()).sub(1).add(e).clamp();
    reflectedLight.indirectSpecular.mulAssign(share);
}

type Setup = (builder: NodeBuilder) => LightingModel | null;

/** The nodes that darken one material, by keys. Each counts its users. */
class Losses {
    private readonly entries = new Map<string, { loss: LossNode; users: number }>();
    private readonly own: { setup: Setup; cacheKey: () => string };
    private readonly setup: Setup;
    private readonly cacheKey: () => string;

    constructor(private readonly material: NodeMaterial) {
        const own = { setup: material.setupLightingModel as unknown as Setup, cacheKey: material.customProgramCacheKey };
        this.own = own;
        this.setup = (builder) => this.darkened(own.setup.call(material, builder), builder);
        // Without a key of its own the renderer would take the program of another material.
        this.cacheKey = () => `${[...this.entries.keys()].join(' ')} ${own.cacheKey.call(material)}`;
        this.show(this.setup, this.cacheKey);
    }
    add(key: string, loss: LossNode): void {
        const entry = this.entries.get(key) ?? { loss, users: 0 };
        this.entries.set(key, entry);
        if (++entry.users === 1) this.material.needsUpdate = true;
    }
    /** Answers whether the material is as it was before the first one. */
    remove(key: string): boolean {
        const entry = this.entries.get(key)!;
        if (--entry.users > 0) return false;
        this.entries.delete(key);
        this.material.needsUpdate = true;
        const { setupLightingModel, customProgramCacheKey } = this.material;
        const isOurs = (setupLightingModel as unknown as Setup) === this.setup && customProgramCacheKey === this.cacheKey;
        if (this.entries.size > 0 || !isOurs) return false;
        this.show(this.own.setup, this.own.cacheKey);
        return true;
    }

    private darkened(model: LightingModel | null, builder: NodeBuilder): LightingModel | null {
        const nodes = [...this.entries.values()].map(({ loss }) => loss(builder)).filter((node) => node);
        if (!model || nodes.length === 0) return model;
        const indirect = model.indirect;
        model.indirect = (context: NodeBuilder) => {
            indirect.call(model, context);
            for (const node of nodes) darken(context, node, this.material instanceof MeshStandardNodeMaterial);
        };
        return model;
    }
    private show(setup: Setup, cacheKey: () => string): void {
        this.material.setupLightingModel = setup as unknown as typeof this.material.setupLightingModel;
        this.material.customProgramCacheKey = cacheKey;
    }
}

const patched = new WeakMap<NodeMaterial, Losses>();

function patchNodes(material: NodeMaterial, key: string, loss: LossNode): () => void {
    const losses = patched.get(material) ?? new Losses(material);
    patched.set(material, losses);
    losses.add(key, loss);
    return () => {
        if (losses.remove(key)) patched.delete(material);
    };
}

/** A node material in the place of another material, for as many as asked for either of them. */
interface Stand {
    material: Material;
    node: NodeMaterial;
    users: number;
}
const stands = new WeakMap<Material, Stand>();

/** The node material of a material, which all that share one go on sharing; what gives it back is put into `undo`. */
function standFor(material: Material, undo: (() => void)[]): NodeMaterial {
    const stand = stands.get(material) ?? { material, node: nodeMaterialOf(material), users: 0 };
    if (stand.node === stand.material) return stand.node;
    for (const one of [stand.material, stand.node]) stands.set(one, stand);
    ++stand.users;
    undo.push(() => {
        if (--stand.users > 0) return;
        for (const one of [stand.material, stand.node]) stands.delete(one);
        stand.node.dispose();
    });
    return stand.node;
}

interface Dressed {
    before: Mesh['material'];
    shown: Mesh['material'];
    users: number;
}
const dressed = new WeakMap<Mesh, Dressed>();

/** Shows a material on a mesh until all that asked for one have undone it. Answers what undoes it. */
function dress(mesh: Mesh, shown: Mesh['material']): () => void {
    const one = dressed.get(mesh) ?? { before: mesh.material, shown, users: 0 };
    dressed.set(mesh, one);
    ++one.users;
    mesh.material = one.shown = shown;
    return () => {
        if (--one.users > 0) return;
        dressed.delete(mesh);
        if (mesh.material === one.shown) mesh.material = one.before;
    };
}

/** Makes the materials of some meshes darken by a node. Materials without nodes are replaced by their node materials,
 * which meshes that share one go on sharing. Answers what undoes it. */
export function patchMeshes(meshes: readonly Mesh[], key: string, loss: LossNode): (() => void)[] {
    const nodes = new Map<Material, NodeMaterial>();
    const undo: (() => void)[] = [];
    const patch = (material: Material): NodeMaterial => {
        const known = nodes.get(material);
        if (known) return known;
        const node = standFor(material, undo);
        nodes.set(material, node).set(node, node);
        undo.push(patchNodes(node, key, loss));
        return node;
    };
    for (const mesh of meshes) {
        const { material } = mesh;
        undo.push(dress(mesh, Array.isArray(material) ? material.map(patch) : patch(material)));
    }
    return undo;
}
