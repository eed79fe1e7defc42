// Layers of the picture of the partition. A layer has an `object` to draw and a function `update(state)`. A new kind of
// picture is one more layer in the list of the scene.
import { BufferAttribute, BufferGeometry, Color, GLSL3, LineBasicMaterial, LineSegments, Points, ShaderMaterial } from 'three';
import { ancestor, bit } from 'septet/data';
import { Surfaces, coefficients, path, value } from 'septet/surfaces';

// The palette of Wong. `many` gives distinguishable colours for many owners: hues by the golden angle, three lightnesses.
const WONG = { light: ['#0072b2', '#e69f00', '#d55e00', '#009e73'], dark: ['#4aa8e0', '#f0b429', '#f0763a', '#2bbd93'] };

export function wong(i, dark) {
    return (dark ? WONG.dark : WONG.light)[i];
}

export function many(i, dark) {
    const lightness = (dark ? [0.66, 0.52, 0.78] : [0.46, 0.33, 0.6])[i % 3];
    return new Color().setHSL((i * 0.381966) % 1, 0.62, lightness);
}

const vertexShader = `
in vec3 tint;
in float weight;
out vec3 shade;
out vec3 place;
out float size;
uniform float pixel;
void main() {
    shade = tint;
    place = position;
    gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
    gl_PointSize = weight * pixel;
    size = gl_PointSize;
}`;

const fragmentShader = `
precision highp float;
in vec3 shade;
in vec3 place;
in float size;
out vec4 colour;
uniform vec4 cut;
uniform float thickness;
void main() {
    float depth = cut.w - dot(cut.xyz, place);
    if (depth < 0.0 || depth > thickness || size < 0.5) discard;
    vec2 r = 2.0 * gl_PointCoord - 1.0;
    float d = dot(r, r);
    if (d > 1.0) discard;
    float light = 0.72 + 0.28 * sqrt(1.0 - d);
    colour = vec4(shade * light, 1.0);
}`;

/** The sampled points. */
export class PointLayer {
    constructor(view, frame, shared) {
        this.view = view;
        const n = view.owner.length;
        const d = view.positions.length / Math.max(n, 1);
        this.places = new Float32Array(3 * n);
        for (let i = 0; i < n; i++) {
            for (let k = 0; k < d; k++) {
                this.places[3 * i + k] = (view.positions[d * i + k] - frame.centre[k]) / frame.size;
            }
        }
        this.ghosts = new Map();
        view.ghost.forEach((point, i) => {
            const leaf = view.ghost_leaf[i];
            this.ghosts.set(leaf, [...(this.ghosts.get(leaf) ?? []), point]);
        });
        this.tints = new BufferAttribute(new Float32Array(3 * n), 3);
        this.weights = new BufferAttribute(new Float32Array(n), 1);
        const geometry = new BufferGeometry();
        geometry.setAttribute('position', new BufferAttribute(this.places, 3));
        geometry.setAttribute('tint', this.tints);
        geometry.setAttribute('weight', this.weights);
        const material = new ShaderMaterial({ uniforms: shared, vertexShader, fragmentShader, glslVersion: GLSL3 });
        this.object = new Points(geometry, material);
        this.object.frustumCulled = false;
        this.base = Math.min(7, Math.max(2.6, (d === 2 ? 480 : 130) / Math.sqrt(Math.max(n, 1)) * (d === 2 ? 1 : 3.2)));
    }

    colour(i, state) {
        const { view } = this;
        const node = view.leaves[view.leaf[i]];
        switch (state.colour) {
        case 'owner':
            return many(view.owner[i] - 1, state.dark);
        case 'node':
            return many(ancestor(node, state.level + 1), state.dark);
        case 'proof':
            return new Color(wong([0, 2, 1][view.flags[i] & 1 ? 1 : (view.flags[i] & 2 ? 2 : 0)], state.dark));
        default: {
            const below = ancestor(node, state.level + 1);
            return below === ancestor(node, state.level)
                ? new Color(state.dark ? '#68737f' : '#aab2bb') : new Color(wong(below % 2, state.dark));
        }
        }
    }

    update(state) {
        const { view } = this;
        const faint = new Color(state.dark ? '#333d48' : '#dde1e6');
        const ghosts = new Set(state.ghosts ? this.ghosts.get(state.leaf) : []);
        let shown = 0;
        for (let i = 0; i < view.owner.length; i++) {
            let colour = this.colour(i, state);
            let weight = this.base;
            const crosses = bit(view.crossing[i], state.level);
            if (state.sets && !crosses) {
                weight = 0;
            }
            if (state.repaired && view.flags[i] & 1) {
                [colour, weight] = [new Color(wong(2, state.dark)), this.base * 1.9];
            }
            if (state.ghosts) {
                const owned = view.leaf[i] === state.leaf;
                colour = owned ? new Color(wong(0, state.dark)) : ghosts.has(i) ? new Color(wong(1, state.dark)) : faint;
                weight = owned || ghosts.has(i) ? this.base * 1.5 : this.base * 0.55;
            }
            this.tints.setXYZ(i, colour.r, colour.g, colour.b);
            this.weights.setX(i, state.points ? weight : 0);
            shown += state.points && weight > 0 ? 1 : 0;
        }
        this.tints.needsUpdate = true;
        this.weights.needsUpdate = true;
        state.shown = shown;
    }
}

/** Returns the separators in the picture's coordinates. */
export function entriesOf(view, frame) {
    const local = (x, i) => ((x ?? 0) - (frame.centre[i] ?? 0)) / frame.size;
    const corner = (c) => [0, 1, 2].map((i) => (i < c.length ? local(c[i], i) : 0));
    return view.separators.map((s) => ({
        node: s.node, level: s.level, low: corner(s.low), high: corner(s.high), surface: coefficients(s, frame),
    }));
}

function tintOf(entry, state) {
    if (entry.level === state.level && state.separators) {
        return { colour: state.dark ? '#dfe6ee' : '#3c4856', opacity: 0.42 };
    }
    if (entry.level < state.level && state.upper) {
        return { colour: state.dark ? '#8a97a6' : '#8792a0', opacity: 0.16 };
    }
    return null;
}

/** Separators in space. */
export class SurfaceLayer {
    constructor(view, frame, shared) {
        this.surfaces = new Surfaces(entriesOf(view, frame), shared, false);
        this.object = this.surfaces.group;
    }

    update(state) {
        this.surfaces.show((entry) => tintOf(entry, state));
    }
}

const STEPS = 720;

/** Separators of the plane: the parts of circles and lines that lie in their node. */
export class CurveLayer {
    constructor(view, frame) {
        const entries = entriesOf(view, frame);
        this.all = new Map(entries.map((entry) => [entry.node, entry]));
        this.object = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
    }

    /** Returns pairs of adjacent places on a surface within the box of its node. */
    trace(entry) {
        const { a, b, c } = entry.surface;
        const above = path(entry.node, this.all);
        const kept = ([x, y]) => x >= entry.low[0] - 0.004 && x <= entry.high[0] + 0.004
            && y >= entry.low[1] - 0.004 && y <= entry.high[1] + 0.004
            && above.every((s) => value(s.surface, [x, y, 0]) * s.side >= 0);
        const places = [];
        // One pass goes by columns and one by rows. Each finds the parts that are not steep in its direction.
        for (const k of [0, 1]) {
            const [u, v] = k === 0 ? [b[0], b[1]] : [b[1], b[0]];
            const roots = (x) => {
                const C = a * x * x + u * x + c;
                if (Math.abs(a) < 1e-12) {
                    return Math.abs(v) < 1e-12 ? [NaN] : [-C / v];
                }
                const disc = v * v - 4 * a * C;
                const q = -0.5 * (v + Math.sign(v || 1) * Math.sqrt(disc));
                return [q / a, C / q].sort((x0, x1) => x0 - x1);
            };
            const [low, high] = [entry.low[k] - 0.004, entry.high[k] + 0.004];
            let last = [];
            for (let i = 0; i <= STEPS; i++) {
                const x = low + ((high - low) * i) / STEPS;
                const now = roots(x).map((y) => (k === 0 ? [x, y] : [y, x]));
                now.forEach((p, j) => {
                    const q = last[j];
                    const steep = q && Math.abs(p[1 - k] - q[1 - k]) > 1.05 * Math.abs(p[k] - q[k]);
                    if (q && !steep && kept(p) && kept(q)) {
                        places.push(...q, 0.01, ...p, 0.01);
                    }
                });
                last = now;
            }
        }
        return places;
    }

    update(state) {
        const shown = [...this.all.values()].filter((entry) => tintOf(entry, state));
        const places = shown.flatMap((entry) => (entry.places ??= this.trace(entry)));
        const geometry = new BufferGeometry();
        geometry.setAttribute('position', new BufferAttribute(new Float32Array(places), 3));
        this.object.geometry.dispose();
        this.object.geometry = geometry;
        this.object.frustumCulled = false;
        this.object.material.color.set(state.dark ? '#f2f5f8' : '#10161d');
    }
}

/** The bounding box of the set. */
export class BoxLayer {
    constructor(view, frame) {
        const half = [0, 1, 2].map((i) => ((view.high[i] ?? 0) - (view.low[i] ?? 0)) / 2 / frame.size);
        const places = [];
        for (let axis = 0; axis < 3; axis++) {
            for (const s of [-1, 1]) {
                for (const t of [-1, 1]) {
                    const corner = (r) => [0, 1, 2].map((i) => half[i] * (i === axis ? r : (i === (axis + 1) % 3 ? s : t)));
                    places.push(...corner(-1), ...corner(1));
                }
            }
        }
        const geometry = new BufferGeometry();
        geometry.setAttribute('position', new BufferAttribute(new Float32Array(places), 3));
        this.object = new LineSegments(geometry, new LineBasicMaterial());
    }

    update(state) {
        this.object.material.color.set(state.dark ? '#3b4652' : '#c3cad2');
    }
}
