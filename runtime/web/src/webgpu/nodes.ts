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

function patchNodes(material: NodeMaterial, key: string, loss: LossNode): () => void {
    const own = { setup: material.setupLightingModel as unknown as Setup, cacheKey: material.customProgramCacheKey };
    const specular = material instanceof MeshStandardNodeMaterial;
    const setup: Setup = (builder) => {
        const model = own.setup.call(material, builder);
        const node = model && loss(builder);
        if (model && node) {
            const indirect = model.indirect;
            model.indirect = (context: NodeBuilder) => {
                indirect.call(model, context);
                darken(context, node, specular);
            };
        }
        return model;
    };
    material.setupLightingModel = setup as unknown as typeof material.setupLightingModel;
    // Without a key of its own the renderer would take the program of another material.
    material.customProgramCacheKey = () => `${key} ${own.cacheKey.call(material)}`;
    material.needsUpdate = true;
    return () => {
        material.setupLightingModel = own.setup as unknown as typeof material.setupLightingModel;
        material.customProgramCacheKey = own.cacheKey;
        material.needsUpdate = true;
    };
}

/** Makes the materials of some meshes darken by a node. Materials without nodes are replaced by their node materials,
 * which meshes that share one go on sharing. Answers what undoes it. */
export function patchMeshes(meshes: readonly Mesh[], key: string, loss: LossNode): (() => void)[] {
    const patched = new Map<Material, NodeMaterial>();
    const undo: (() => void)[] = [];
    const patch = (material: Material): NodeMaterial => {
        const known = patched.get(material);
        if (known) return known;
        const node = nodeMaterialOf(material);
        patched.set(material, node);
        undo.push(patchNodes(node, key, loss));
        if (node !== material) undo.push(() => node.dispose());
        return node;
    };
    for (const mesh of meshes) {
        const before = mesh.material;
        mesh.material = Array.isArray(before) ? before.map(patch) : patch(before);
        undo.push(() => (mesh.material = before));
    }
    return undo;
}
