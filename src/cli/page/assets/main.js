import { mesh, tables, view } from 'septet/data';
import { startTheme } from 'septet/theme';
import { tie } from 'septet/tables';

startTheme(document.getElementById('theme'));

// In a figure with variants, the choice shows one drawing and its table.
for (const details of document.querySelectorAll('details[data-table]')) {
    const id = details.dataset.table;
    if (!tables[id]) {
        continue;
    }
    const select = document.querySelector(`select[data-figure="${id}"]`);
    const refresh = tie(details, () => tables[id][select ? Number(select.value) : 0]);
    select?.addEventListener('change', () => {
        const drawings = document.querySelectorAll(`#${id} .drawing`);
        drawings.forEach((drawing, i) => {
            drawing.hidden = i !== Number(select.value);
        });
        refresh();
    });
}

if (view) {
    const { startScene } = await import('septet/scene');
    startScene();
}
if (mesh) {
    const { startMesh } = await import('septet/mesh');
    startMesh();
}
document.documentElement.dataset.ready = 'true';
