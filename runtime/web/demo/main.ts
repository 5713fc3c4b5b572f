import { PenumbraError, load } from 'penumbra-player';
import type { PenumbraEnvironment } from 'penumbra-player/three';
import { Actor, type Shadow } from './actor';
import { Stage } from './stage';

const CLIPS: Record<string, string> = { Walk: 'walk.glb', Run: 'run.glb', Jump: 'jump.glb' };
const SKIES: Record<string, string> = { City: 'city.exr', Indoors: 'apartment.exr' };
const TRACED = 'Walk';

const find = <T extends HTMLElement>(selector: string) => document.querySelector<T>(selector)!;
const panel = find<HTMLFormElement>('#panel');
const divider = find('#divider');
const stats = find('#stats');
const message = find('#message');

function addChoices(id: string, name: string, values: string[]): void {
    find(id).innerHTML = values
        .map((value) => `<label><input type="radio" name="${name}" value="${value}"><span>${value}</span></label>`)
        .join('');
}

/** What the panel says. It is kept in the address, so that a link shows the same. */
function readPanel() {
    const form = new FormData(panel);
    return {
        shadow: form.get('shadow') as Shadow,
        clip: form.get('clip') as string,
        sky: form.get('sky') as string,
        turn: Number(form.get('turn')),
        sun: form.has('sun'),
        compare: form.has('compare'),
        paused: form.has('paused'),
    };
}

function restorePanel(): void {
    const from = new URLSearchParams(location.hash.slice(1));
    const set = (name: string, fallback: string) => {
        const value = from.get(name) ?? fallback;
        const field = panel.elements.namedItem(name);
        if (field instanceof RadioNodeList) {
            field.value = value;
            if (field.value !== value) field.value = fallback; // no such choice
        }
        else if (field instanceof HTMLInputElement && field.type === 'checkbox') field.checked = value === 'true';
        else if (field instanceof HTMLInputElement) field.value = value;
    };
    const defaults = { shadow: 'colour', clip: TRACED, sky: 'City', turn: '0', sun: 'false', compare: 'false', paused: 'false' };
    for (const [name, fallback] of Object.entries(defaults)) set(name, fallback);
}

/** The page, once all is loaded. */
class Page {
    private split = 0;
    private last = 0;
    private hz = 60;
    private environment!: PenumbraEnvironment;

    constructor(
        readonly stage: Stage,
        readonly actor: Actor,
    ) {
        stage.scene.add(actor.root);
        panel.addEventListener('input', (event) => this.changed(event.target as HTMLInputElement));
        addEventListener('resize', () => (stage.resize(), this.moveDivider()));
        divider.addEventListener('pointerdown', (event) => divider.setPointerCapture(event.pointerId));
        divider.addEventListener('pointermove', (event) => {
            if (!divider.hasPointerCapture(event.pointerId)) return;
            this.split = Math.min(Math.max(event.clientX / innerWidth, 0.05), 0.95);
            this.moveDivider();
        });
    }

    async changed(field?: HTMLInputElement): Promise<void> {
        // Truth was traced for one clip alone.
        if (field?.name === 'compare' && field.checked) (panel.elements.namedItem('clip') as RadioNodeList).value = TRACED;
        if (field?.name === 'clip' && field.value !== TRACED) (panel.elements.namedItem('compare') as HTMLInputElement).checked = false;
        const state = readPanel();
        this.environment = await this.stage.setSky(SKIES[state.sky]);
        this.stage.turn((state.turn * Math.PI) / 180);
        this.stage.sun.visible = state.sun;
        this.actor.setShadow(state.shadow, this.environment);
        this.actor.play(state.clip);
        divider.hidden = !state.compare;
        this.moveDivider();
        history.replaceState(null, '', `#${new URLSearchParams(Object.entries(state).map(([name, value]) => [name, String(value)]))}`);
    }
    private moveDivider(): void {
        if (this.split === 0) this.split = this.stage.middle;
        divider.style.left = `${100 * this.split}%`;
    }

    /** Draws a moment; shadows of the model fill the window, or its left part beside those that were traced. */
    draw(): void {
        const compare = !divider.hidden;
        this.actor.compute();
        this.stage.draw(0, compare ? this.split : 1);
        if (!compare) return;
        this.actor.showTruth();
        this.stage.draw(this.split, 1);
    }
    frame(now: number): void {
        const seconds = Math.min((now - this.last) / 1000, 0.1);
        if (this.last > 0 && now > this.last) this.hz += 0.05 * (1000 / (now - this.last) - this.hz);
        this.last = now;
        if (!readPanel().paused) this.actor.advance(seconds);
        this.draw();
        stats.textContent = `${this.actor.ms.toFixed(1)} ms · ${this.hz.toFixed(0)} Hz`;
        stats.title = 'time of the shadows of a frame on the processor, and frames a second';
    }
}

async function main(): Promise<void> {
    addChoices('#clips', 'clip', Object.keys(CLIPS));
    addChoices('#skies', 'sky', Object.keys(SKIES));
    restorePanel();
    const stage = new Stage(find<HTMLCanvasElement>('#view'));
    const page = new Page(stage, await Actor.load(await load(), stage.ground, CLIPS));
    await page.changed();
    stage.renderer.setAnimationLoop((now) => page.frame(now));
    message.hidden = true;
    Object.assign(globalThis, { penumbraDemo: page }); // for the console, and for pictures of the page
}

main().catch((error) => {
    message.textContent = error instanceof PenumbraError ? `${error.code}: ${error.message}` : `The page cannot start: ${error.message ?? error}`;
    console.error(error);
});
