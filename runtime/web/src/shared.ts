export { PenumbraError, type PenumbraCode } from './error.js';
export {
    Asset,
    Character,
    Runtime,
    Scene,
    ScenePoints,
    Shading,
    createRuntime,
    type Clip,
    type Light,
    type Place,
    type Quality,
} from './core.js';
export { hasSimd } from './instantiate.js';
