// The cells of a mesh on one side of a plane. Their visible faces are drawn in the colours of the cells.
import { BufferAttribute, BufferGeometry, DoubleSide, GLSL3, Mesh, ShaderMaterial } from 'three';

const vertexShader = `
in vec3 tint;
flat out vec3 shade;
out vec2 corner; // two of three weights
#ifdef RELIEF
out vec3 place;
#endif
void main() {
    shade = tint;
#ifdef RELIEF
    place = position;
#endif
    int k = gl_VertexID % 3;
    corner = vec2(k == 0, k == 1);
    gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
}`;

const fragmentShader = `
precision highp float;
flat in vec3 shade;
in vec2 corner;
out vec4 colour;
uniform vec3 light, line;
uniform float edges;
#ifdef RELIEF
in vec3 place;
#endif
void main() {
    vec3 lit = shade;
#ifdef RELIEF
    vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
    lit *= 0.65 + 0.35 * abs(dot(normal, light));
#endif
    vec3 weights = vec3(corner, 1.0 - corner.x - corner.y);
    vec3 width = fwidth(weights);
    vec3 near = smoothstep(vec3(0.0), 1.3 * width, weights);
    float edge = 1.0 - min(near.x, min(near.y, near.z));
    // A face of a few pixels would consist of edges only.
    float room = 1.0 - smoothstep(0.12, 0.45, max(width.x, max(width.y, width.z)));
    colour = vec4(mix(lit, line, 0.75 * edges * room * edge), 1.0);
}`;

/** Writes three numbers at a position, in ascending order. */
function writeSorted(out, at, a, b, c) {
    out[at] = Math.min(a, b, c);
    out[at + 2] = Math.max(a, b, c);
    out[at + 1] = a + b + c - out[at] - out[at + 2];
}

/** For each corner of each tetrahedron, returns the cell across the opposite face, or -1 if there is none. */
export function neighboursOf(corners) {
    const faces = corners.length;
    const across = new Int32Array(faces).fill(-1);
    const keys = new Uint32Array(3 * faces);
    for (let f = 0; f < faces; f += 1) {
        const cell = f - (f % 4);
        const [a, b, c] = [1, 2, 3].map((k) => corners[cell + ((f + k) % 4)]);
        writeSorted(keys, 3 * f, a, b, c);
    }
    // A hash table, with open addressing, of the faces whose other cell has not been found.
    const size = 2 ** Math.ceil(Math.log2(2 * faces + 2));
    const table = new Int32Array(size).fill(-1);
    for (let f = 0; f < faces; f += 1) {
        const [a, b, c] = [keys[3 * f], keys[3 * f + 1], keys[3 * f + 2]];
        let at = (Math.imul(a, 0x9e3779b1) ^ Math.imul(b, 0x85ebca6b) ^ Math.imul(c, 0xc2b2ae35)) >>> 0;
        at = (at ^ (at >>> 15)) & (size - 1);
        for (;;) {
            const g = table[at];
            if (g < 0) {
                table[at] = f;
                break;
            }
            if (keys[3 * g] === a && keys[3 * g + 1] === b && keys[3 * g + 2] === c) {
                across[f] = g >> 2;
                across[g] = f >> 2;
                break;
            }
            at = (at + 1) & (size - 1);
        }
    }
    return across;
}

/** Returns the mean of the points of each cell, three numbers per cell, in the unit of the file. */
export function centresOf(mesh) {
    const { dimension: d, cells, corners, positions } = mesh;
    const centres = new Float64Array(3 * cells);
    for (let c = 0; c < cells; c += 1) {
        for (let i = 0; i < d; i += 1) {
            let sum = 0;
            for (let k = 0; k <= d; k += 1) {
                sum += positions[d * corners[(d + 1) * c + k] + i];
            }
            centres[3 * c + i] = sum / (d + 1);
        }
    }
    return centres;
}

export class CellLayer {
    constructor(mesh, frame) {
        const { dimension: d, points, positions } = mesh;
        this.d = d;
        this.corners = Uint32Array.from(mesh.corners);
        this.count = mesh.cells;
        this.places = new Float32Array(3 * points);
        for (let i = 0; i < points; i += 1) {
            for (let k = 0; k < d; k += 1) {
                this.places[3 * i + k] = (positions[d * i + k] - frame.centre[k]) / frame.size;
            }
        }
        this.centres = centresOf(mesh);
        this.across = d === 3 ? neighboursOf(this.corners) : null;
        this.kept = new Uint8Array(this.count).fill(1);
        this.tints = new Float32Array(3 * this.count);
        // The visible faces. Each is one number for its cell and the opposite corner, or, in the plane, its cell.
        this.faces = new Uint32Array(0);
        this.drawn = 0;
        this.capacity = 0;
        this.uniforms = {
            light: { value: [0, 0, 1] }, line: { value: [0, 0, 0] }, edges: { value: 1 },
        };
        this.geometry = new BufferGeometry();
        this.object = new Mesh(this.geometry, new ShaderMaterial({
            uniforms: this.uniforms, vertexShader, fragmentShader, glslVersion: GLSL3, side: DoubleSide,
            defines: d === 3 ? { RELIEF: '' } : {},
        }));
        this.object.frustumCulled = false;
    }

    /** Returns the height of a cell's centre along a direction. */
    height(cell, normal) {
        const at = 3 * cell;
        return normal[0] * this.centres[at] + normal[1] * this.centres[at + 1] + normal[2] * this.centres[at + 2];
    }

    /** Returns the smallest and the largest height. */
    range(normal) {
        let [low, high] = [Infinity, -Infinity];
        for (let c = 0; c < this.count; c += 1) {
            const h = this.height(c, normal);
            low = Math.min(low, h);
            high = Math.max(high, h);
        }
        return [low, high];
    }

    /** Keeps the cells below the plane (above it if `over` is set), or all cells if there is no plane. */
    cut(plane) {
        for (let c = 0; c < this.count; c += 1) {
            const above = plane && this.height(c, plane.normal) - plane.offset;
            this.kept[c] = !plane || (plane.over ? above >= 0 : above <= 0) ? 1 : 0;
        }
        this.find();
        this.build();
    }

    /** Finds the faces of kept cells that do not belong to another kept cell. */
    find() {
        const { kept, across, d } = this;
        const most = d === 3 ? 4 * this.count : this.count;
        if (this.faces.length < most) {
            this.faces = new Uint32Array(most);
        }
        let n = 0;
        for (let c = 0; c < this.count; c += 1) {
            if (kept[c] && d === 2) {
                this.faces[n++] = c;
            } else if (kept[c]) {
                for (let f = 4 * c; f < 4 * c + 4; f += 1) {
                    if (across[f] < 0 || !kept[across[f]]) {
                        this.faces[n++] = f;
                    }
                }
            }
        }
        this.drawn = n;
    }

    room() {
        if (this.drawn <= this.capacity) {
            return;
        }
        this.capacity = Math.ceil(1.5 * this.drawn);
        this.geometry.dispose();
        for (const name of ['position', 'tint']) {
            this.geometry.setAttribute(name, new BufferAttribute(new Float32Array(9 * this.capacity), 3));
        }
    }

    build() {
        this.room();
        const { corners, places, tints, faces, d } = this;
        const { position, tint } = this.geometry.attributes;
        this.geometry.setDrawRange(0, 3 * this.drawn);
        for (let i = 0; i < this.drawn; i += 1) {
            const cell = d === 3 ? faces[i] >> 2 : faces[i];
            for (let k = 0; k < 3; k += 1) {
                const point = d === 3 ? corners[4 * cell + ((faces[i] + k + 1) & 3)] : corners[3 * cell + k];
                for (let j = 0; j < 3; j += 1) {
                    position.array[9 * i + 3 * k + j] = places[3 * point + j];
                    tint.array[9 * i + 3 * k + j] = tints[3 * cell + j];
                }
            }
        }
        if (position) {
            position.needsUpdate = true;
            tint.needsUpdate = true;
        }
    }
}
