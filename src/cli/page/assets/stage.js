// The common part of all pictures: a canvas, a camera that turns, and a loop that draws after a change.
import { ColorManagement, LinearSRGBColorSpace, Scene, WebGLRenderer } from 'three';
import { Camera } from 'septet/camera';
import { hasWebGL, projection, sayPlain } from 'septet/plain';

// The shaders write colours as the style sheet gives them, without conversion.
ColorManagement.enabled = false;

/** Returns the centre and the size of a box. They map the picture to a unit cube around 0. */
export function frameOf(low, high) {
    const centre = [0, 1, 2].map((i) => ((low[i] ?? 0) + (high[i] ?? 0)) / 2);
    const size = Math.max(...low.map((l, i) => high[i] - l)) || 1;
    return { centre, size };
}

export class Stage {
    /** `before(width, height)` is called after the camera is set and before the scene is drawn. */
    constructor(canvas, flat, before) {
        this.canvas = canvas;
        this.before = before;
        this.ratio = Math.min(window.devicePixelRatio, 2);
        if (hasWebGL()) {
            this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
            this.renderer.setPixelRatio(this.ratio);
            this.renderer.outputColorSpace = LinearSRGBColorSpace;
        } else {
            this.context = canvas.getContext('2d');
            sayPlain(canvas.parentElement);
        }
        this.scene = new Scene();
        this.turning = false;
        this.camera = new Camera(canvas, flat, () => this.request());
        new ResizeObserver(() => this.request()).observe(canvas.parentElement);
    }

    request() {
        if (!this.pending) {
            this.pending = requestAnimationFrame(() => {
                this.pending = null;
                this.draw();
            });
        }
    }

    draw() {
        const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
        if (this.width !== width || this.height !== height) {
            [this.width, this.height] = [width, height];
            this.renderer?.setSize(width, height, false);
            if (this.context) {
                [this.canvas.width, this.canvas.height] = [width * this.ratio, height * this.ratio];
            }
        }
        if (this.turning) {
            this.camera.place.turn += 0.006;
            this.request();
        }
        this.camera.look(width, height);
        this.before(width, height);
        if (this.renderer) {
            this.renderer.render(this.scene, this.camera.eye);
        } else {
            this.context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
            this.context.clearRect(0, 0, width, height);
            this.plain(this.context, projection(this.camera.eye, width, height));
        }
    }

    /** Connects the buttons that every picture has. */
    buttons({ reset, turn, png }, name) {
        reset.addEventListener('click', () => this.camera.reset());
        turn.addEventListener('click', () => {
            this.turning = !this.turning;
            turn.setAttribute('aria-pressed', String(this.turning));
            this.request();
        });
        png.addEventListener('click', () => {
            this.draw();
            const link = document.createElement('a');
            link.href = this.canvas.toDataURL('image/png');
            link.download = name;
            link.click();
        });
    }

    /** Connects keys to the camera and to the actions in `more`. */
    keys(more) {
        const { camera } = this;
        const acts = {
            ArrowLeft: () => camera.turn(-0.12, 0), ArrowRight: () => camera.turn(0.12, 0),
            ArrowUp: () => camera.turn(0, 0.1), ArrowDown: () => camera.turn(0, -0.1),
            '+': () => camera.scale(1.2), '=': () => camera.scale(1.2), '-': () => camera.scale(1 / 1.2),
            0: () => camera.reset(), ...more,
        };
        this.canvas.addEventListener('keydown', (event) => {
            const act = acts[event.key];
            if (act && !event.ctrlKey && !event.metaKey && !event.altKey) {
                event.preventDefault();
                act();
            }
        });
    }
}
