// The partition: its layers, the controls next to them, and the table of the points.
import { Matrix4, Vector3, Vector4 } from 'three';
import { bit, direct, space, view } from 'septet/data';
import { isDark, onTheme } from 'septet/theme';
import { tie } from 'septet/tables';
import { drawLines, drawPoints } from 'septet/plain';
import { Stage, frameOf } from 'septet/stage';
import { BoxLayer, CurveLayer, PointLayer, SurfaceLayer, wong } from 'septet/layers';

const get = (id) => document.getElementById(id);
const EVERYTHING = 1e6;
// The proof of the stars without flags: `triangulate` needs no hypothesis.
const unmarked = direct ? 'direct' : 'hypothesis';

class Picture extends Stage {
    constructor() {
        super(get('canvas'), space === 2, (width, height) => this.prepare(height));
        this.flat = space === 2;
        this.shared = {
            cut: { value: new Vector4(0, 0, 0, 1) }, thickness: { value: EVERYTHING }, pixel: { value: 1 },
            towards: { value: new Vector3() }, clip: { value: new Matrix4() },
        };
        const frame = frameOf(view.low, view.high);
        const separators = this.flat ? new CurveLayer(view, frame) : new SurfaceLayer(view, frame, this.shared);
        this.points = new PointLayer(view, frame, this.shared);
        this.box = new BoxLayer(view, frame);
        this.curves = this.flat ? separators : null;
        this.layers = [this.box, this.points, separators];
        for (const layer of this.layers) {
            this.scene.add(layer.object);
        }
    }

    /** Reads the controls and updates every layer. */
    update() {
        const on = (id) => get(id).checked;
        this.state = {
            dark: isDark(), colour: get('colour').value, level: Number(get('level').value), leaf: Number(get('leaf').value),
            points: on('show-points'), separators: on('show-separators'), upper: on('show-upper'), sets: on('show-sets'),
            ghosts: on('show-ghosts'), repaired: on('show-repaired'),
        };
        for (const layer of this.layers) {
            layer.update(this.state);
        }
        this.request();
    }

    slice() {
        const axis = get('axis').value;
        const at = Number(get('slice').value) - 0.5;
        get('slice-value').textContent = (at + 0.5).toFixed(2);
        const normal = axis === 'view' ? this.camera.direction() : new Vector3(...[0, 1, 2].map((i) => (Number(axis) === i ? 1 : 0)));
        const thin = axis !== '' && get('thin').checked;
        this.shared.thickness.value = thin ? 0.06 : EVERYTHING;
        if (axis === '') {
            this.shared.cut.value.set(0, 0, 0, 1);
        } else {
            this.shared.cut.value.set(normal.x, normal.y, normal.z, at * (axis === 'view' ? 1.75 : 1.02) + (thin ? 0.03 : 0));
        }
    }

    /** Draws without WebGL. */
    plain(context, project) {
        const { dark } = this.state;
        drawLines(context, project, this.box.object.geometry, dark ? '#3b4652' : '#c3cad2');
        const { places, tints, weights } = this.points;
        const points = { places, tints: tints.array, weights: weights.array };
        const { cut, thickness, pixel } = this.shared;
        drawPoints(context, project, points, { cut: cut.value, thickness: thickness.value, pixel: pixel.value / this.ratio });
        if (this.curves) {
            drawLines(context, project, this.curves.object.geometry, dark ? '#f2f5f8' : '#10161d');
        }
    }

    prepare(height) {
        this.slice();
        this.shared.pixel.value = this.ratio * Math.max(1, Math.sqrt(this.camera.place.zoom)) * (height / 544);
        this.shared.towards.value.copy(this.camera.direction());
        const { eye } = this.camera;
        this.shared.clip.value.multiplyMatrices(eye.projectionMatrix, eye.matrixWorldInverse);
    }
}

function describe(picture) {
    const { state } = picture;
    const at = view.separators.filter((s) => s.level === state.level);
    const crossing = view.crossing.filter((mask) => bit(mask, state.level)).length;
    get('readout').textContent = `level ${state.level}: ${at.length} splits, ${crossing} of ${view.points} sampled points `
        + `in their separator sets (of ${view.of} points)`;
}

/** Shows the key of the colours in use. */
function key(state) {
    const names = {
        side: [['inside', wong(0, state.dark)], ['outside', wong(1, state.dark)]],
        owner: [], node: [],
        proof: [[unmarked, wong(0, state.dark)], ['local radius', wong(1, state.dark)], ['exchange', wong(2, state.dark)]],
    }[state.colour];
    const ghosts = [['owned points of the leaf', wong(0, state.dark)], ['its ghosts', wong(1, state.dark)]];
    const rows = state.ghosts ? ghosts : [...names, ...(state.repaired ? [['repaired star', wong(2, state.dark)]] : [])];
    get('key').replaceChildren(...rows.map(([name, colour]) => {
        const item = document.createElement('li');
        const swatch = document.createElement('span');
        swatch.className = 'swatch';
        swatch.style.background = colour;
        item.append(swatch, name);
        return item;
    }));
}

/** Fills the list of the leaves with ghosts, in the order of their positions. */
function fillLeaves(picture) {
    const leaves = [...picture.points.ghosts.keys()].sort((a, b) => a - b);
    get('leaf').replaceChildren(...leaves.map((leaf) => {
        const count = picture.points.ghosts.get(leaf).length;
        return new Option(`node ${view.leaves[leaf]} (${count} ghosts)`, String(leaf));
    }));
    get('show-ghosts').disabled = leaves.length === 0;
}

function table() {
    const names = ['x', 'y', 'z'].slice(0, space);
    const columns = [...names, 'owner', 'leaf', 'levels whose separator set holds it', 'proved by', 'ghost in leaves'];
    const ghosts = new Map();
    view.ghost.forEach((point, i) => {
        ghosts.set(point, [...(ghosts.get(point) ?? []), view.leaves[view.ghost_leaf[i]]]);
    });
    const proof = (flags) => (flags & 1 ? 'exchange' : flags & 2 ? 'local radius' : unmarked);
    const rows = view.owner.map((owner, i) => {
        const leaf = view.leaves[view.leaf[i]];
        const depth = Math.floor(Math.log2(leaf));
        const levels = Array.from({ length: depth }, (_, l) => l).filter((l) => bit(view.crossing[i], l));
        const x = view.positions.slice(space * i, space * (i + 1));
        return [...x, owner, leaf, levels.join(' '), proof(view.flags[i]), (ghosts.get(i) ?? []).join(' ')];
    });
    return { columns, rows };
}

export function startScene() {
    if (direct) {
        // A person who triangulates points looks for the points first.
        get('colour').value = 'owner';
        get('show-separators').checked = false;
        get('partition-title').textContent = 'The points';
    }
    const picture = new Picture();
    const deepest = Math.max(0, ...view.separators.map((s) => s.level));
    get('level').max = deepest;
    fillLeaves(picture);
    if (picture.flat) {
        get('axis').querySelectorAll('[value="2"], [value="view"]').forEach((option) => option.remove());
        get('turn').hidden = true;
    }
    const refresh = () => {
        get('level-value').textContent = `${get('level').value} of ${deepest}`;
        get('leaf-row').hidden = !get('show-ghosts').checked;
        picture.update();
        key(picture.state);
        describe(picture);
    };
    const step = (by) => {
        get('level').value = Number(get('level').value) + by;
        refresh();
    };
    get('controls').addEventListener('submit', (event) => event.preventDefault());
    get('controls').addEventListener('input', refresh);
    get('level-up').addEventListener('click', () => step(-1));
    get('level-down').addEventListener('click', () => step(1));
    const slide = (by) => {
        get('slice').value = Number(get('slice').value) + by;
        picture.request();
    };
    picture.buttons({ reset: get('reset'), turn: get('turn'), png: get('png') }, 'partition.png');
    picture.keys({ PageUp: () => step(-1), PageDown: () => step(1), '[': () => slide(-0.02), ']': () => slide(0.02) });
    tie(document.querySelector('[data-table="partition"]'), table);
    onTheme(refresh);
    refresh();
}
