export { PenumbraWorker, WorkerAsset, WorkerCharacter, startWorker } from './client.js';
export { Crowd, LEVELS, type CrowdLevel, type CrowdMember } from './crowd.js';
export { serve, type WorkerScope } from './serve.js';
export type { WorkerUpdate } from './messages.js';
export { PenumbraError, type PenumbraCode } from '../error.js';
