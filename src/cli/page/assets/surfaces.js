// Draws separators exactly. Each fragment of a node's box finds the place where its ray meets the surface a |x|^2 + b
// . x + c = 0, and keeps it if it lies on the node's side of every separator above the node.
import { BackSide, BoxGeometry, Color, GLSL3, Group, Mesh, ShaderMaterial, Vector3, Vector4 } from 'three';

const MOST_ABOVE = 24;
// A sphere whose radius is larger than this many diameters of the set is drawn as its tangent plane.
const FLAT = 1e4;

const vertexShader = `
out vec3 place;
void main() {
    place = (modelMatrix * vec4(position, 1.0)).xyz;
    gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
}`;

const fragmentShader = `
precision highp float;
in vec3 place;
out vec4 colour;
uniform vec4 surface;   // b, c
uniform float square;   // a
uniform vec4 above[${MOST_ABOVE}];
uniform vec2 sides[${MOST_ABOVE}]; // a, and the side that the node lies on
uniform int count;
uniform vec3 low, high, towards, tint;
uniform vec4 cut;       // normal, offset: kept where normal . x <= offset
uniform float thickness, opacity;
uniform mat4 clip;

bool inside(vec3 x) {
    if (any(lessThan(x, low)) || any(greaterThan(x, high))) return false;
    float depth = cut.w - dot(cut.xyz, x);
    if (depth < 0.0 || depth > thickness) return false;
    for (int i = 0; i < ${MOST_ABOVE}; i++) {
        if (i >= count) break;
        float f = sides[i].x * dot(x, x) + dot(above[i].xyz, x) + above[i].w;
        if (f * sides[i].y < 0.0) return false;
    }
    return true;
}

void main() {
    // From the back of the box towards the eye.
    float A = square;
    float B = 2.0 * square * dot(place, towards) + dot(surface.xyz, towards);
    float C = square * dot(place, place) + dot(surface.xyz, place) + surface.w;
    float disc = B * B - 4.0 * A * C;
    if (disc < 0.0) discard;
    float q = -0.5 * (B + (B < 0.0 ? -1.0 : 1.0) * sqrt(disc));
    float t0 = abs(A) > 1e-12 ? q / A : -1.0;
    float t1 = abs(q) > 1e-12 ? C / q : -1.0;
    float far = min(t0, t1), near = max(t0, t1);
    vec3 x = place + near * towards;
    if (near < 0.0 || !inside(x)) {
        x = place + far * towards;
        if (far < 0.0 || !inside(x)) discard;
    }
    vec3 normal = normalize(2.0 * square * x + surface.xyz);
    float facing = abs(dot(normal, towards));
    float light = 0.55 + 0.45 * abs(dot(normal, normalize(towards + vec3(0.3, -0.4, 0.6))));
    colour = vec4(tint * light, opacity + 0.35 * (1.0 - facing) * (1.0 - facing));
    vec4 p = clip * vec4(x, 1.0);
    gl_FragDepth = 0.5 * p.z / p.w + 0.5;
}`;

/** Returns the coefficients of a separator in the picture's coordinates. Its function is positive outside the interior. */
export function coefficients(separator, frame) {
    const v = separator.vector;
    const at = (i) => (v[i] ?? 0);
    if (separator.kind === 'plane') {
        const b = [at(0), at(1), at(2)];
        const c = b.reduce((sum, bi, i) => sum + bi * frame.centre[i], -separator.number) / frame.size;
        return { a: 0, b, c };
    }
    const centre = [0, 1, 2].map((i) => (at(i) - frame.centre[i] * (i < v.length ? 1 : 0)) / frame.size);
    const radius = separator.number / frame.size;
    const sign = separator.interior === 'ball' ? 1 : -1;
    const far = Math.hypot(...centre);
    if (radius > FLAT) {
        const b = centre.map((x) => (-sign * x) / far);
        return { a: 0, b, c: sign * (far - radius) };
    }
    const scale = sign / (2 * radius);
    const c = (far - radius) * (far + radius) * scale;
    return { a: scale, b: centre.map((x) => -2 * x * scale), c };
}

/** Returns the value of a surface's function at a place. */
export function value(s, x) {
    const dot = (u, w) => u[0] * w[0] + u[1] * w[1] + u[2] * w[2];
    return s.a * dot(x, x) + dot(s.b, x) + s.c;
}

/** Returns the separators above a node, each with the sign of the side on which the node lies. */
export function path(node, all) {
    const found = [];
    for (let at = node; at > 1; at = Math.floor(at / 2)) {
        const parent = all.get(Math.floor(at / 2));
        if (parent) {
            found.push({ surface: parent.surface, side: at % 2 === 0 ? -1 : 1 });
        }
    }
    return found;
}

/** Returns the mesh that draws one separator. */
function mesh(entry, all, shared, flat) {
    const above = path(entry.node, all).slice(-MOST_ABOVE);
    const pad = (list, empty) => [...list, ...Array(MOST_ABOVE - list.length).fill(empty)];
    const vector = (s) => new Vector4(...s.b, s.c);
    const room = 0.004;
    const low = entry.low.map((x) => x - room);
    const high = entry.high.map((x) => x + room);
    const uniforms = {
        ...shared,
        surface: { value: vector(entry.surface) },
        square: { value: entry.surface.a },
        above: { value: pad(above.map((s) => vector(s.surface)), new Vector4()) },
        sides: { value: pad(above.map((s) => [s.surface.a, s.side]), [0, 0]).flat() },
        count: { value: above.length },
        low: { value: new Vector3(...low) },
        high: { value: new Vector3(...high) },
        tint: { value: new Color() },
        opacity: { value: 0.3 },
    };
    const material = new ShaderMaterial({
        uniforms, vertexShader, fragmentShader, glslVersion: GLSL3, transparent: true, depthWrite: false, side: BackSide,
    });
    const size = low.map((x, i) => Math.max(high[i] - x, flat && i === 2 ? 0.01 : 1e-4));
    const box = new Mesh(new BoxGeometry(...size), material);
    box.position.set(...low.map((x, i) => x + size[i] / 2));
    box.renderOrder = 2;
    return box;
}

/** All separators. The mesh of each is made when it is first shown. */
export class Surfaces {
    constructor(entries, shared, flat) {
        this.group = new Group();
        this.shared = shared;
        this.flat = flat;
        this.all = new Map(entries.map((entry) => [entry.node, entry]));
    }

    /** Shows the separators for which `tint` returns a colour and an opacity. */
    show(tint) {
        for (const entry of this.all.values()) {
            const shown = tint(entry);
            if (!shown) {
                if (entry.mesh) {
                    entry.mesh.visible = false;
                }
                continue;
            }
            if (!entry.mesh) {
                entry.mesh = mesh(entry, this.all, this.shared, this.flat);
                this.group.add(entry.mesh);
            }
            entry.mesh.visible = true;
            entry.mesh.material.uniforms.tint.value.set(shown.colour);
            entry.mesh.material.uniforms.opacity.value = shown.opacity;
        }
    }
}
