// A camera that turns around the centre of the set by pointer, wheel and keys. Sets of the plane are seen from above.
import { OrthographicCamera, Vector3 } from 'three';

const START = { turn: 0.65, tilt: 0.42, zoom: 1, x: 0, y: 0 };
const ABOVE = { ...START, turn: 0, tilt: Math.PI / 2 };

export class Camera {
    constructor(canvas, flat, changed) {
        this.eye = new OrthographicCamera(-1, 1, 1, -1, -20, 20);
        this.flat = flat;
        this.changed = changed;
        this.reset();
        canvas.addEventListener('pointerdown', (e) => canvas.setPointerCapture(e.pointerId));
        canvas.addEventListener('pointermove', (e) => this.drag(e, canvas));
        canvas.addEventListener('wheel', (e) => {
            e.preventDefault();
            this.scale(Math.exp(-e.deltaY * 0.0012));
        }, { passive: false });
    }

    reset() {
        this.place = { ...(this.flat ? ABOVE : START) };
        this.changed();
    }

    drag(event, canvas) {
        if (!(event.buttons & 1)) {
            return;
        }
        const unit = 2 / canvas.clientHeight;
        if (event.shiftKey || this.flat) {
            this.place.x -= (event.movementX * unit) / this.place.zoom;
            this.place.y += (event.movementY * unit) / this.place.zoom;
            this.changed();
        } else {
            this.turn(-event.movementX * 0.008, event.movementY * 0.008);
        }
    }

    turn(by, tilt) {
        if (this.flat) {
            this.place.x -= by;
            this.place.y += tilt;
        } else {
            this.place.turn += by;
            this.place.tilt = Math.min(1.55, Math.max(-1.55, this.place.tilt + tilt));
        }
        this.changed();
    }

    scale(by) {
        this.place.zoom = Math.min(40, Math.max(0.3, this.place.zoom * by));
        this.changed();
    }

    /** Unit vector from the centre towards the eye. */
    direction() {
        const { turn, tilt } = this.place;
        return new Vector3(Math.cos(tilt) * Math.sin(turn), -Math.cos(tilt) * Math.cos(turn), Math.sin(tilt));
    }

    /** Sets the eye for a picture of this width and height. */
    look(width, height) {
        const { zoom, x, y, turn, tilt } = this.place;
        const [h, w] = [this.flat ? 0.62 : 0.88, (this.flat ? 0.62 : 0.88) * (width / height)];
        this.eye.left = -w / zoom + x;
        this.eye.right = w / zoom + x;
        this.eye.top = h / zoom + y;
        this.eye.bottom = -h / zoom + y;
        const upright = new Vector3(-Math.sin(tilt) * Math.sin(turn), Math.sin(tilt) * Math.cos(turn), Math.cos(tilt));
        this.eye.up.copy(upright);
        this.eye.position.copy(this.direction().multiplyScalar(4));
        this.eye.lookAt(0, 0, 0);
        this.eye.updateProjectionMatrix();
        this.eye.updateMatrixWorld();
    }
}
