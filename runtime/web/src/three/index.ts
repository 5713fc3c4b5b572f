export { PenumbraCharacter, type PenumbraCharacterOptions } from './character.js';
export { PenumbraEnvironment, type EquirectangularOptions } from './environment.js';
export { PenumbraGround, type PenumbraGroundOptions } from './ground.js';
export { PenumbraLoader, assetOf } from './loader.js';
export { PenumbraScene } from './scene.js';
export type { Sun } from '../sh.js';
export { PenumbraError, type PenumbraCode } from '../error.js';
