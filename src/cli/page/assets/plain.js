// Pictures without WebGL: the geometry of the layers, projected and drawn on a 2D canvas from far to near.
import { Vector3 } from 'three';

/** Returns whether the browser can draw with WebGL. */
export function hasWebGL() {
    try {
        const context = document.createElement('canvas').getContext('webgl2');
        context?.getExtension('WEBGL_lose_context')?.loseContext();
        return Boolean(context);
    } catch {
        return false;
    }
}

/** Adds a sentence about the missing WebGL to a picture. */
export function sayPlain(stage) {
    const note = document.createElement('p');
    note.className = 'plain';
    note.setAttribute('role', 'note');
    note.textContent = 'This browser has no WebGL. The picture is simpler: without shading, and without surfaces in space.';
    stage.prepend(note);
}

/** Returns a function from a place to its pixel and its depth, which grows away from the eye. */
export function projection(eye, width, height) {
    const at = new Vector3();
    return (x, y, z) => {
        at.set(x, y, z).project(eye);
        return [((at.x + 1) * width) / 2, ((1 - at.y) * height) / 2, at.z];
    };
}

const css = (array, at) => `rgb(${[0, 1, 2].map((k) => Math.round(255 * array[at + k])).join(' ')})`;

/** Draws the segments of a geometry. */
export function drawLines(context, project, geometry, colour) {
    const places = geometry.attributes.position?.array ?? [];
    context.strokeStyle = colour;
    context.lineWidth = 1;
    context.beginPath();
    for (let i = 0; i + 5 < places.length; i += 6) {
        const [x, y] = project(places[i], places[i + 1], places[i + 2]);
        const [u, v] = project(places[i + 3], places[i + 4], places[i + 5]);
        context.moveTo(x, y);
        context.lineTo(u, v);
    }
    context.stroke();
}

/** Draws points that are in a slice, with a tint and a diameter for each. */
export function drawPoints(context, project, { places, tints, weights }, { cut, thickness, pixel }) {
    const order = [];
    for (let i = 0; 3 * i < places.length; i += 1) {
        const [x, y, z] = places.subarray(3 * i, 3 * i + 3);
        const depth = cut.w - (cut.x * x + cut.y * y + cut.z * z);
        if (weights[i] > 0 && depth >= 0 && depth <= thickness) {
            order.push([i, ...project(x, y, z)]);
        }
    }
    order.sort((a, b) => b[3] - a[3]);
    for (const [i, x, y] of order) {
        context.fillStyle = css(tints, 3 * i);
        context.beginPath();
        context.arc(x, y, Math.max(0.6, (weights[i] * pixel) / 2), 0, 2 * Math.PI);
        context.fill();
    }
}

/** Draws the first triangles of a geometry, with their edges if a colour of lines is given. */
export function drawTriangles(context, project, { position, tint }, count, line) {
    const order = [];
    for (let i = 0; i < count; i += 1) {
        const corners = [0, 3, 6].map((k) => project(...position.array.subarray(9 * i + k, 9 * i + k + 3)));
        order.push([i, corners, corners[0][2] + corners[1][2] + corners[2][2]]);
    }
    order.sort((a, b) => b[2] - a[2]);
    context.lineWidth = 0.6;
    context.lineJoin = 'round';
    for (const [i, corners] of order) {
        context.beginPath();
        corners.forEach(([x, y], k) => (k === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
        context.closePath();
        context.fillStyle = css(tint.array, 9 * i);
        context.fill();
        context.strokeStyle = line ?? context.fillStyle;
        context.stroke();
    }
}
