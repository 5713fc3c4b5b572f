import { Scene, type Runtime } from '../core.js';
import { PenumbraError } from '../error.js';
import type { PenumbraCharacter } from './character.js';

/** Characters that darken one another as well as themselves. */
export class PenumbraScene {
    private readonly scene: Scene;

    /** The page evaluates them: characters of a worker are refused. Their roots may turn and move, but not scale. */
    constructor(
        runtime: Runtime,
        readonly characters: readonly PenumbraCharacter[],
    ) {
        if (characters.some((one) => one.evaluatesElsewhere))
            throw new PenumbraError('INVALID_ARGUMENT', 'a worker evaluates a character alone, without what others cast on it');
        this.scene = new Scene(runtime, characters.map((one) => one.asset));
    }

    /** Takes the place of the characters' own updates: once a frame, after the mixers. */
    update(): void {
        this.characters.forEach((one, i) => {
            one.evaluate();
            this.scene.setCaster(i, one.character, one.place);
        });
        this.characters.forEach((one, i) => {
            this.scene.cast(one.character, i, one.place);
            one.show();
        });
    }
    /** Gives memory back; the characters stay. A second call does nothing. */
    dispose(): void {
        this.scene.dispose();
    }
}
