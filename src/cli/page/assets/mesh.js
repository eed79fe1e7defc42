// The mesh: the cells on one side of a plane, the controls next to them, and the table of the kept cells.
import { Color, Vector3 } from 'three';
import { mesh } from 'septet/data';
import { isDark, onTheme } from 'septet/theme';
import { tie } from 'septet/tables';
import { drawLines, drawTriangles } from 'septet/plain';
import { Stage, frameOf } from 'septet/stage';
import { BoxLayer } from 'septet/layers';
import { CellLayer } from 'septet/cells';
import { scalesOf, short } from 'septet/scales';

const get = (id) => document.getElementById(`mesh-${id}`);
const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

/** Returns the plane's normal before it is turned, and the two directions towards which it turns. */
function directions(axis, camera) {
    if (axis === 'view') {
        const { turn } = camera.place;
        const eye = camera.direction();
        const right = [Math.cos(turn), Math.sin(turn), 0];
        const up = [
            eye.y * right[2] - eye.z * right[1], eye.z * right[0] - eye.x * right[2], eye.x * right[1] - eye.y * right[0],
        ];
        return [[eye.x, eye.y, eye.z], right, up];
    }
    const first = Number(axis);
    if (mesh.dimension === 2) {
        return first === 0 ? [AXES[0], AXES[1], AXES[2]] : [AXES[1], [-1, 0, 0], AXES[2]];
    }
    return [0, 1, 2].map((i) => AXES[(first + i) % 3]);
}

class Picture extends Stage {
    constructor() {
        super(get('canvas'), mesh.dimension === 2, () => this.prepare());
        const frame = frameOf(mesh.low, mesh.high);
        this.cells = new CellLayer(mesh, frame);
        this.box = new BoxLayer(mesh, frame);
        this.scene.add(this.box.object, this.cells.object);
        this.scales = scalesOf(mesh);
    }

    get scale() {
        return this.scales[get('colour').value];
    }

    /** Returns the plane that the controls select, or `null` without a plane. */
    plane() {
        const axis = get('axis').value;
        if (axis === '') {
            return null;
        }
        const [n, u, v] = directions(axis, this.camera);
        const [a, b] = ['lean', 'tip'].map((id) => (Number(get(id).value) * Math.PI) / 180);
        const normal = n.map((x, i) => Math.cos(b) * (Math.cos(a) * x + Math.sin(a) * u[i]) + Math.sin(b) * v[i]);
        const key = normal.join();
        if (this.normal !== key) {
            this.normal = key;
            this.range = this.cells.range(normal);
        }
        const [low, high] = this.range;
        const at = Number(get('position').value);
        const offset = at >= 1 ? high : low + at * (high - low);
        return { normal, offset, over: get('over').checked };
    }

    /** Cuts the mesh again if the plane has moved. */
    prepare() {
        const plane = this.plane();
        const key = JSON.stringify(plane);
        if (this.cutAt !== key) {
            this.cutAt = key;
            this.cells.cut(plane);
            this.describe(plane);
            this.refreshTable?.();
        }
        // The light comes from above the eye.
        const light = this.camera.direction().add(new Vector3(0.3, -0.4, 0.6)).normalize();
        this.cells.uniforms.light.value = light.toArray();
    }

    /** Draws without WebGL. */
    plain(context, project) {
        const dark = isDark();
        drawLines(context, project, this.box.object.geometry, dark ? '#3b4652' : '#c3cad2');
        const line = get('edges').checked ? (dark ? '#05080c' : '#1b2430') : null;
        drawTriangles(context, project, this.cells.geometry.attributes, this.cells.drawn, line);
    }

    /** Updates the colours. */
    update() {
        const dark = isDark();
        this.scale.paint(this.cells.tints, dark);
        this.cells.build();
        const line = new Color(dark ? '#05080c' : '#1b2430');
        this.cells.uniforms.line.value = [line.r, line.g, line.b];
        this.cells.uniforms.edges.value = get('edges').checked ? 1 : 0;
        this.box.update({ dark });
        get('key').replaceChildren(...this.scale.key(dark));
        this.request();
    }

    describe(plane) {
        const kept = this.cells.kept.reduce((sum, k) => sum + k, 0);
        const about = this.scale.describe(this.cells.kept);
        get('readout').textContent = `${kept} of ${mesh.cells} cells, ${this.cells.drawn} faces drawn${about && `; ${about}`}`;
        const names = ['x', 'y', 'z'];
        const term = (x, i) => (Math.abs(x) < 5e-4 ? '' : `${Number(x.toFixed(3))} ${names[i]}`);
        const sum = plane?.normal.map(term).filter(Boolean).join(' + ').replaceAll('+ -', '− ').replace(/^1 (.)$/, '$1');
        get('place').textContent = plane ? `${sum} ${plane.over ? '≥' : '≤'} ${short(plane.offset)}` : 'all cells';
    }
}

/** Returns the table of the kept cells. */
function table(picture) {
    const d = mesh.dimension;
    const names = ['x', 'y', 'z'].slice(0, d).map((x) => `${x} of the centre`);
    const columns = ['cell', ...names, 'radius-edge ratio', 'smallest angle [degrees]', 'size f', 'region'];
    const rows = [];
    const { kept, centres } = picture.cells;
    for (let c = 0; c < mesh.cells; c += 1) {
        if (kept[c]) {
            const row = [c, ...centres.subarray(3 * c, 3 * c + d), mesh.radius_edge[c], mesh.least_angle[c], mesh.size[c]];
            row.push(mesh.regions[mesh.region[c]]);
            rows.push(mesh.owner ? [...row, mesh.owner[c]] : row);
        }
    }
    return { columns: mesh.owner ? [...columns, 'worker'] : columns, rows };
}

export function startMesh() {
    const picture = new Picture();
    if (mesh.dimension === 2) {
        get('axis').querySelectorAll('[value="2"], [value="view"]').forEach((option) => option.remove());
        get('tip-row').hidden = true;
        get('turn').hidden = true;
        get('axis').value = '';
    }
    if (!mesh.owner) {
        get('colour').querySelector('[value="owner"]').remove();
    }
    const move = () => {
        for (const id of ['lean', 'tip']) {
            get(`${id}-value`).textContent = `${get(id).value}°`;
        }
        for (const id of ['position', 'lean', 'tip', 'over']) {
            get(id).disabled = get('axis').value === '';
        }
        picture.request();
    };
    const refresh = () => {
        picture.update();
        picture.describe(picture.plane());
    };
    const slide = (id, by) => {
        get(id).value = Number(get(id).value) + by;
        move();
    };
    get('controls').addEventListener('submit', (event) => event.preventDefault());
    get('controls').addEventListener('input', (event) => {
        if (event.target === get('colour') || event.target === get('edges')) {
            refresh();
        } else {
            move();
        }
    });
    picture.buttons({ reset: get('reset'), turn: get('turn'), png: get('png') }, 'mesh.png');
    picture.keys({
        '[': () => slide('position', -0.02), ']': () => slide('position', 0.02),
        PageUp: () => slide('lean', -5), PageDown: () => slide('lean', 5),
    });
    picture.refreshTable = tie(document.querySelector('[data-table="mesh"]'), () => table(picture));
    onTheme(refresh);
    picture.draw();
    move();
    refresh();
}
