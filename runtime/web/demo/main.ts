import { PenumbraError, load } from 'penumbra-player';
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

function showError(error: Error): void {
    const code = error instanceof PenumbraError ? error.code : 'Something has failed';
    message.textContent = `${code}: ${error.message ?? error}`;
    message.hidden = false;
    console.error(error);
}

function addChoices(id: string, name: string, values: string[]): void {
    find(id).innerHTML = values
        .map((value) => `<label><input type="radio" name="${name}" value="${value}"><span>${value}</span></label>`)
        .join('');
}

/** Reads the panel. Its state is kept in the address, so that a link shows the same. */
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
    const paused = String(matchMedia('(prefers-reduced-motion: reduce)').matches);
    const defaults = { shadow: 'colour', clip: TRACED, sky: 'City', turn: '0', sun: 'false', compare: 'false', paused };
    for (const [name, fallback] of Object.entries(defaults)) set(name, fallback);
}

function rememberPanel(): void {
    const words = Object.entries(readPanel()).map(([name, value]) => [name, String(value)]);
    history.replaceState(null, '', `#${new URLSearchParams(words)}`);
}

/** The page, once all is loaded. */
class Page {
    private split = 0;
    private last = 0;
    private hz = 60;

    constructor(
        readonly stage: Stage,
        readonly actor: Actor,
    ) {
        stage.scene.add(actor.root);
        panel.addEventListener('input', (event) => this.changed(event.target as HTMLInputElement).catch(showError));
        panel.addEventListener('change', rememberPanel); // not at each step of a slider: browsers limit how often
        panel.addEventListener('submit', (event) => event.preventDefault());
        addEventListener('resize', () => (stage.resize(), this.moveDivider()));
        divider.addEventListener('pointerdown', (event) => divider.setPointerCapture(event.pointerId));
        divider.addEventListener('pointermove', (event) => {
            if (!divider.hasPointerCapture(event.pointerId)) return;
            this.moveDivider(event.clientX / innerWidth);
        });
        divider.addEventListener('keydown', (event) => {
            const step = { ArrowLeft: -0.02, ArrowDown: -0.02, ArrowRight: 0.02, ArrowUp: 0.02 }[event.key];
            if (step === undefined) return;
            event.preventDefault();
            this.moveDivider(this.split + step);
        });
    }

    async changed(field?: HTMLInputElement): Promise<void> {
        // Truth was traced for one clip alone.
        if (field?.name === 'compare' && field.checked) (panel.elements.namedItem('clip') as RadioNodeList).value = TRACED;
        if (field?.name === 'clip' && field.value !== TRACED) (panel.elements.namedItem('compare') as HTMLInputElement).checked = false;
        const name = readPanel().sky;
        const sky = await this.stage.loadSky(SKIES[name]);
        const state = readPanel(); // the panel may have changed during the load
        if (state.sky !== name) return; // another sky was chosen, and a call for it is under way
        this.stage.useSky(sky);
        this.stage.turn((state.turn * Math.PI) / 180);
        this.stage.sun.visible = state.sun;
        this.actor.setShadow(state.shadow, sky.environment);
        this.actor.play(state.clip);
        divider.hidden = !state.compare;
        this.moveDivider();
        message.hidden = true;
    }
    private moveDivider(to = this.split || this.stage.middle): void {
        this.split = Math.min(Math.max(to, 0.05), 0.95);
        divider.style.left = `${100 * this.split}%`;
        divider.setAttribute('aria-valuenow', (100 * this.split).toFixed(0));
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
    rememberPanel();
    stage.renderer.setAnimationLoop((now) => page.frame(now));
    Object.assign(globalThis, { penumbraDemo: page }); // for the console, and for pictures of the page
}

main().catch(showError);
