// The data of the page: tables by figure, the view and its dimension, the mesh.
const data = JSON.parse(document.getElementById('data').textContent);

export const tables = data.tables;
export const view = data.view;
export const direct = data.direct;
export const space = data.space;
export const mesh = data.mesh;

/** Returns the ancestor of a node on a level, or the node itself if it is above that level. */
export function ancestor(node, level) {
    const depth = Math.floor(Math.log2(node));
    return depth <= level ? node : Math.floor(node / 2 ** (depth - level));
}

/** Returns bit `level` of a mask that may be longer than 32 bits. */
export function bit(mask, level) {
    return Math.floor(mask / 2 ** level) % 2 === 1;
}
