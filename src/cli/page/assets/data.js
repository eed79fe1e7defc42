// What the page was made with: tables by figure, the view and its dimension, the mesh.
const data = JSON.parse(document.getElementById('data').textContent);

export const tables = data.tables;
export const view = data.view;
export const space = data.space;
export const mesh = data.mesh;

/** The ancestor of a node on a level, or the node itself where it lies above. */
export function ancestor(node, level) {
    const depth = Math.floor(Math.log2(node));
    return depth <= level ? node : Math.floor(node / 2 ** (depth - level));
}

/** Bit `level` of a mask that may be longer than 32 bits. */
export function bit(mask, level) {
    return Math.floor(mask / 2 ** level) % 2 === 1;
}
