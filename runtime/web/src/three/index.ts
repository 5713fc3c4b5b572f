export { PenumbraCharacter, type PenumbraCharacterOptions } from './character.js';
export { PenumbraEnvironment } from './environment.js';
export { PenumbraGround, type PenumbraGroundOptions } from './ground.js';
export { PenumbraLoader, assetOf } from './loader.js';
export { PenumbraError, type PenumbraCode } from '../error.js';
