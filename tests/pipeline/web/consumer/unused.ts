import { Character, load } from 'penumbra-player';
import { PenumbraGround, PenumbraLoader } from 'penumbra-player/three';
import { GpuEvaluator, PenumbraCharacter } from 'penumbra-player/three/webgpu';
import { Crowd, PenumbraWorker, startWorker } from 'penumbra-player/worker';
import { load as loadFile } from 'penumbra-player/no-inline';
