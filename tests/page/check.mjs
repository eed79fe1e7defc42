// A page of `septet report` in headless Chromium: nothing is fetched, nothing complains, every control works,
// pictures are not blank, tables download as CSV that parses, keys do what they say.
//
//     node check.mjs PAGE.html SCREENSHOTS [MESH.json]
//
// With the report of the mesh that the page shows its numbers are compared with those of the page.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const [file, shots, reportFile] = process.argv.slice(2);
const launch = (graphics) => chromium.launch({
    executablePath: process.env.SEPTET_CHROMIUM ?? '/usr/bin/chromium',
    args: [
        '--headless', '--no-sandbox', ...graphics,
        '--disable-background-networking', '--disable-component-update', '--disable-sync', '--no-first-run',
    ],
});
const browser = await launch(['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']);
let passed = 0;

function parse(text) {
    const rows = [[]];
    const field = /("(?:[^"]|"")*"|[^",\r\n]*)(,|\r\n|$)/y;
    while (field.lastIndex < text.length) {
        const found = field.exec(text);
        assert.ok(found, 'not CSV');
        rows.at(-1).push(found[1].startsWith('"') ? found[1].slice(1, -1).replaceAll('""', '"') : found[1]);
        if (found[2] !== ',') {
            rows.push([]);
        }
    }
    rows.pop();
    return rows;
}

async function open(colorScheme, on = browser) {
    const page = await on.newPage({ viewport: { width: 1280, height: 900 }, colorScheme, acceptDownloads: true });
    const faults = [];
    page.on('console', (m) => ['error', 'warning'].includes(m.type()) && !/GPU stall|swiftshader/i.test(m.text()) && faults.push(m.text()));
    page.on('pageerror', (e) => faults.push(String(e)));
    page.on('request', (r) => !/^(data|blob):/.test(r.url()) && r.url() !== pathToFileURL(file).href && faults.push(`request ${r.url()}`));
    const start = Date.now();
    await page.goto(pathToFileURL(file).href);
    await page.waitForSelector('html[data-ready=true]', { timeout: 60_000 });
    return { page, faults, milliseconds: Date.now() - start };
}

/** Looks at the picture, in the page: how many colours it has, and how many pixels changed since the last look. */
async function look(page, id = 'canvas') {
    return page.evaluate(async (id) => {
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        const canvas = document.getElementById(id);
        const copy = document.createElement('canvas');
        [copy.width, copy.height] = [canvas.width, canvas.height];
        const context = copy.getContext('2d', { willReadFrequently: true });
        context.drawImage(canvas, 0, 0);
        const now = new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer);
        const last = window.lastLook ?? now;
        window.lastLook = now;
        let changed = 0;
        for (let i = 0; i < now.length; i += 1) {
            changed += now[i] !== last[i] ? 1 : 0;
        }
        return { changed, colours: new Set(now).size };
    }, id);
}

async function changes(page, what, act, id = 'canvas') {
    await look(page, id);
    await act();
    const { changed } = await look(page, id);
    assert.ok(changed > 10, `${what} changes nothing`);
    passed += 1;
}

async function figures(page) {
    for (const drawing of await page.locator('.drawing:not([hidden]) > svg').all()) {
        assert.ok(await drawing.locator('path, rect').count() > 3, 'an empty figure');
        assert.ok((await drawing.getAttribute('aria-label')).length > 3);
        // Words that stand on each other.
        const clash = await drawing.evaluate((svg) => {
            const boxes = [...svg.querySelectorAll('text:not([transform])')].map((t) => [t.textContent, t.getBoundingClientRect()]);
            for (const [i, [a, p]] of boxes.entries()) {
                for (const [b, q] of boxes.slice(i + 1)) {
                    const wide = Math.min(p.right, q.right) - Math.max(p.left, q.left);
                    const high = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
                    if (wide > 1 && high > 4) return `${a} | ${b}`;
                }
            }
            return null;
        });
        assert.equal(clash, null, 'labels overlap');
        passed += 1;
    }
    for (const select of await page.locator('select[data-figure]').all()) {
        const id = await select.getAttribute('data-figure');
        const count = await select.locator('option').count();
        for (let i = 0; i < count; i += 1) {
            await select.selectOption(String(i));
            assert.equal(await page.locator(`#${id} .drawing:not([hidden])`).count(), 1);
            assert.ok(await page.locator(`#${id} .drawing`).nth(i).isVisible());
        }
        await select.selectOption('0');
        passed += 1;
    }
}

async function tables(page) {
    for (const details of await page.locator('details[data-table]').all()) {
        const id = await details.getAttribute('data-table');
        await details.locator('summary').click();
        await details.locator('tbody tr').first().waitFor({ timeout: 5000 });
        const rows = await details.locator('tbody tr').count();
        assert.ok(rows > 0, `no table under ${id}`);
        const [download] = await Promise.all([page.waitForEvent('download'), details.locator('.csv').click()]);
        assert.equal(download.suggestedFilename(), `${id}.csv`);
        const csv = parse(await readFile(await download.path(), 'utf8'));
        assert.ok(csv.length - 1 >= rows && csv.every((row) => row.length === csv[0].length), `CSV of ${id}`);
        await details.locator('summary').click();
        passed += 1;
    }
}

/** At each width, nothing is wider than the window, and every link of the bar is in it. */
async function widths(page, name) {
    for (const width of [400, 1300, 2000]) {
        await page.setViewportSize({ width, height: 900 });
        await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
        const beyond = await page.evaluate(() => {
            const inside = (e) => e.closest('.rows, svg, pre');
            const wide = (e) => e.getBoundingClientRect().right > window.innerWidth + 1 || e.getBoundingClientRect().left < -1;
            const all = [...document.querySelectorAll('body *:not(.skip)')].filter((e) => e.checkVisibility() && !inside(e));
            const names = all.filter(wide).map((e) => `${e.tagName} ${e.id} ${e.className} ${e.textContent.slice(0, 40)}`);
            const { scrollWidth } = document.documentElement;
            return [...names, ...(scrollWidth > window.innerWidth ? [`the page is ${scrollWidth} wide`] : [])];
        });
        assert.deepEqual(beyond, [], `${width} pixels: beyond the window`);
        await page.screenshot({ path: `${shots}/${name}-${width}.png`, fullPage: true });
        passed += 1;
    }
    await page.setViewportSize({ width: 1280, height: 900 });
}

/** The page of `triangulate`: the data first, then quality, degrees and the run. */
async function data(page) {
    const order = await page.locator('main > section').evaluateAll((all) => all.map((section) => section.id));
    assert.deepEqual(order.slice(0, 5), ['partition', 'summary', 'quality', 'degrees', 'details']);
    assert.match(await page.locator('.repeat').textContent(), /^septet triangulate .* --stats$/);
    const cards = await page.locator('#details').textContent();
    for (const word of ['time', 'memory', 'file', 'extent', 'convex hull']) {
        assert.ok(cards.includes(word), `no ${word}`);
    }
    passed += 1;
}

/** Without WebGL, every picture says so and shows something on a 2D canvas. */
async function withoutGraphics() {
    const plain = await launch(['--disable-3d-apis']);
    const { page, faults } = await open('light', plain);
    for (const id of ['canvas', 'mesh-canvas']) {
        if (await page.locator(`#${id}`).count()) {
            assert.ok((await look(page, id)).colours > 10, 'a blank picture without WebGL');
            const note = page.locator('.stage', { has: page.locator(`#${id}`) }).locator('.plain');
            assert.match(await note.textContent(), /no WebGL/);
            assert.ok(await note.isVisible());
            await page.locator(`#${id}`).focus();
            for (const key of ['ArrowLeft', '+', '0']) {
                await changes(page, `${key} without WebGL`, () => page.keyboard.press(key), id);
            }
            await page.locator('.stage', { has: page.locator(`#${id}`) }).screenshot({ path: `${shots}/plain-${id}.png` });
        }
    }
    await widths(page, 'plain');
    assert.deepEqual(faults, []);
    await plain.close();
}

async function scene(page) {
    if (await page.locator('#details').count()) {
        // A page of `triangulate` begins with the points alone.
        assert.equal(await page.locator('#show-separators').isChecked(), false);
        await page.locator('#show-separators').click();
        await page.locator('#colour').selectOption('side');
    }
    const flat = !(await page.locator('#turn').isVisible());
    assert.ok((await look(page)).colours > 20, 'a blank picture');
    const deepest = Number(await page.locator('#level').getAttribute('max'));
    // `triangulate` may cut a small set only once.
    assert.ok(deepest > 0 || await page.locator('#details').count());
    if (deepest > 0) {
        await changes(page, 'level', () => page.locator('#level-down').click());
        await changes(page, 'level', () => page.locator('#level-up').click());
    }
    for (const colour of ['owner', 'node', 'proof', 'side']) {
        await changes(page, `colour by ${colour}`, () => page.locator('#colour').selectOption(colour));
    }
    for (const id of ['points', 'sets', 'separators']) {
        await changes(page, id, () => page.locator(`#show-${id}`).click());
        await changes(page, id, () => page.locator(`#show-${id}`).click());
    }
    if (deepest > 0) {
        await page.locator('#level-down').click();
        await changes(page, 'upper', () => page.locator('#show-upper').click());
        await page.locator('#show-upper').click();
    }
    if (await page.locator('#show-ghosts').isEnabled()) {
        await changes(page, 'ghosts', () => page.locator('#show-ghosts').click());
        await changes(page, 'leaf', async () => page.locator('#leaf').selectOption({ index: (await page.locator('#leaf option').count()) - 1 }));
        await page.locator('#show-ghosts').click();
    }
    const repaired = await page.evaluate(() => JSON.parse(document.getElementById('data').textContent).view.flags.some((f) => f & 1));
    if (repaired) {
        await changes(page, 'repaired', () => page.locator('#show-repaired').click());
    }
    await changes(page, 'slice', () => page.locator('#axis').selectOption('0'));
    await changes(page, 'slice position', () => page.locator('#slice').fill('0.7'));
    await changes(page, 'thin slice', () => page.locator('#thin').click());
    await page.locator('#thin').click();
    await page.locator('#canvas').focus();
    const steps = deepest > 0 ? ['PageDown', 'PageUp'] : [];
    for (const key of ['ArrowLeft', 'ArrowUp', '+', '-', ...steps, '[', ']']) {
        await changes(page, key, () => page.keyboard.press(key));
    }
    await changes(page, '0', () => page.keyboard.press('0'));
    const box = await page.locator('#canvas').boundingBox();
    await changes(page, 'drag', async () => {
        await page.mouse.move(box.x + 200, box.y + 200);
        await page.mouse.down();
        await page.mouse.move(box.x + 260, box.y + 230, { steps: 3 });
        await page.mouse.up();
    });
    await changes(page, 'wheel', () => page.mouse.wheel(0, -300));
    await changes(page, 'reset', () => page.locator('#reset').click());
    await page.locator('#axis').selectOption('');
    if (!flat) {
        await changes(page, 'turn', () => page.locator('#turn').click());
        await page.locator('#turn').click();
        await page.locator('#reset').click();
    }
    const [png] = await Promise.all([page.waitForEvent('download'), page.locator('#png').click()]);
    assert.equal((await readFile(await png.path())).subarray(1, 4).toString(), 'PNG');
}

const sum = (list) => list.reduce((a, b) => a + b, 0);
const least = (list) => list.reduce((a, b) => Math.min(a, b), Infinity);
const largest = (list) => list.reduce((a, b) => Math.max(a, b), -Infinity);

/** The means of cells' points, by the report. */
function centres({ view, domain }) {
    const d = domain.dimension;
    return Array.from({ length: view.cells }, (_, c) => {
        const points = view.corners.slice((d + 1) * c, (d + 1) * (c + 1));
        return Array.from({ length: d }, (_, i) => sum(points.map((p) => view.positions[d * p + i])) / (d + 1));
    });
}

/** How many cells lie below the plane at a part of the way along an axis; those on it may count or not. */
function below(heights, part) {
    const [low, high] = [least(heights), largest(heights)];
    const offset = low + part * (high - low);
    const slack = 1e-9 * (high - low);
    return [heights.filter((h) => h <= offset - slack).length, heights.filter((h) => h <= offset + slack).length];
}

/** Faces of these cells that no other of them has. */
function outerFaces({ view, domain }, kept) {
    if (domain.dimension === 2) {
        return kept.length;
    }
    const faces = new Map();
    for (const c of kept) {
        const cell = view.corners.slice(4 * c, 4 * c + 4);
        for (const v of cell) {
            const key = cell.filter((w) => w !== v).sort((a, b) => a - b).join();
            faces.set(key, (faces.get(key) ?? 0) + 1);
        }
    }
    return [...faces.values()].filter((n) => n === 1).length;
}

const shown = async (page) => (await page.locator('#mesh-readout').textContent()).match(/\d+/g).slice(0, 3).map(Number);

/** The plane: what is kept, counted again from the report. */
async function plane(page, report) {
    const all = centres(report);
    const settle = () => look(page, 'mesh-canvas');
    const d = report.domain.dimension;
    await page.locator('#mesh-axis').selectOption('');
    await settle();
    const everything = [...all.keys()];
    assert.deepEqual(await shown(page), [all.length, all.length, outerFaces(report, everything)], 'all cells');
    for (let axis = 0; axis < d; axis += 1) {
        const heights = all.map((x) => x[axis]);
        await changes(page, `plane ${axis}`, () => page.locator('#mesh-axis').selectOption(String(axis)), 'mesh-canvas');
        for (const part of [0.3, 0.75]) {
            await changes(page, `position ${part}`, () => page.locator('#mesh-position').fill(String(part)), 'mesh-canvas');
            const [kept, of, drawn] = await shown(page);
            const [fewest, most] = below(heights, part);
            assert.ok(of === all.length && kept >= fewest && kept <= most, `axis ${axis} at ${part}: ${kept}, ${fewest}..${most}`);
            const offset = Number((await page.locator('#mesh-place').textContent()).match(/[-\d.e]+$/)[0]);
            const chosen = everything.filter((c) => heights[c] <= offset);
            // The page shows four digits of the offset. Cells between that offset and the plane may be on either side.
            if (chosen.length === kept) {
                assert.equal(drawn, outerFaces(report, chosen), `faces of axis ${axis} at ${part}`);
            }
            await page.locator('#mesh-over').click();
            await settle();
            const [others] = await shown(page);
            assert.ok(others >= all.length - most && others <= all.length - fewest, 'the other side');
            await page.locator('#mesh-over').click();
        }
        await page.locator('#mesh-position').fill('0.5');
        passed += 1;
    }
    await changes(page, 'turn of the plane', () => page.locator('#mesh-lean').fill('40'), 'mesh-canvas');
    if (d === 3) {
        await changes(page, 'tilt of the plane', () => page.locator('#mesh-tip').fill('-30'), 'mesh-canvas');
        await changes(page, 'plane of the view', () => page.locator('#mesh-axis').selectOption('view'), 'mesh-canvas');
    }
    // A plane turned by a right angle is that of another axis.
    await page.locator('#mesh-tip').fill('0').catch(() => {});
    await page.locator('#mesh-axis').selectOption('0');
    await page.locator('#mesh-lean').fill('90');
    await settle();
    const [turned] = await shown(page);
    const [fewest, most] = below(all.map((x) => x[1]), 0.5);
    assert.ok(turned >= fewest && turned <= most, `turned by a right angle: ${turned}, ${fewest}..${most}`);
    await page.locator('#mesh-lean').fill('0');
    passed += 1;
}

/** Colours and their keys against the report. */
async function colours(page, report) {
    const { view } = report;
    const key = page.locator('#mesh-key');
    for (const field of ['least_angle', 'size', 'radius_edge']) {
        await page.locator('#mesh-colour').selectOption(field);
        await look(page, 'mesh-canvas');
        const ticks = await key.locator('[data-value]').evaluateAll((all) => all.map((t) => [Number(t.dataset.value), Number(t.textContent)]));
        const values = view[field].filter((v) => v !== null);
        assert.equal(ticks[0][0], least(values), `least ${field}`);
        assert.equal(ticks.at(-1)[0], largest(values), `largest ${field}`);
        assert.ok(ticks.every(([v, said]) => Math.abs(v - said) <= 1e-3 * Math.abs(v)), `key of ${field}`);
        assert.ok(ticks.every(([v], i) => i === 0 || v > ticks[i - 1][0]), `key of ${field} does not ascend`);
        passed += 1;
    }
    // Workers own no cells of a mesh that was improved or refined.
    assert.equal(await page.locator('#mesh-colour [value="owner"]').count(), view.owner ? 1 : 0, 'colour by worker');
    const named = [['region', 'region', (i) => `region ${view.regions[i]}`], ['owner', 'owner', (p) => `worker ${p}`]];
    for (const [option, field, name] of named.filter(([, field]) => view[field])) {
        await changes(page, `colour by ${option}`, () => page.locator('#mesh-colour').selectOption(option), 'mesh-canvas');
        const said = await key.locator('[data-count]').evaluateAll((all) => all.map((t) => [t.dataset.value, Number(t.dataset.count)]));
        const counts = new Map();
        view[field].forEach((v) => counts.set(name(v), (counts.get(name(v)) ?? 0) + 1));
        assert.deepEqual(new Map(said), counts, `key of ${option}`);
        passed += 1;
    }
    await changes(page, 'colour by angle', () => page.locator('#mesh-colour').selectOption('least_angle'), 'mesh-canvas');
    await changes(page, 'colour by size', () => page.locator('#mesh-colour').selectOption('radius_edge'), 'mesh-canvas');
}

/** A whole table under a figure, by variant. */
async function rowsOf(page, id, variant) {
    const all = await page.evaluate(() => JSON.parse(document.getElementById('data').textContent).tables);
    const names = await page.locator(`select[data-figure="${id}"] option`).allTextContents();
    const at = names.indexOf(variant);
    assert.ok(at >= 0, `${id} shows no ${variant}, but ${names}`);
    return all[id][at].rows;
}

/** Figures of the mesh against its report. */
async function figuresOfMesh(page, report) {
    const histograms = { 'radius-edge ratios': 'radius_edge', 'edges over f': 'length_over_size' };
    for (const [name, field] of Object.entries(histograms)) {
        const rows = await rowsOf(page, 'mesh-quality', name);
        const { counts, below: under, above } = report.quality[field];
        const expected = [...(under ? [under] : []), ...counts, ...(above ? [above] : [])];
        assert.deepEqual(rows.map((r) => r[2]), expected, name);
    }
    const counts = await rowsOf(page, 'mesh-stages', 'points');
    const keys = ['name', 'candidates', 'points', 'completion_rounds', 'set_rounds', 'rounds', 'messages', 'bytes', 'work', 'depth', 'seconds'];
    assert.deepEqual(counts, report.stages.map((s) => keys.map((k) => s[k])), 'stages');
    const phases = await rowsOf(page, 'mesh-phases', 'work');
    assert.equal(sum(phases.map((r) => r[5])), sum(report.stages.map((s) => s.bytes)), 'bytes of phases');
    const cards = await page.locator('#mesh-summary dl').textContent();
    const number = (x) => String(x).replace(/\B(?=(\d{3})+$)/g, '\u202f');
    for (const x of [report.mesh.points, report.mesh.cells, sum(report.stages.map((s) => s.messages))]) {
        assert.ok(cards.includes(number(x)), `no ${number(x)} in the summary`);
    }
    passed += 4;
}

async function mesh(page, report) {
    assert.ok((await look(page, 'mesh-canvas')).colours > 20, 'a blank picture of the mesh');
    await plane(page, report);
    await colours(page, report);
    await figuresOfMesh(page, report);
    await changes(page, 'edges', () => page.locator('#mesh-edges').click(), 'mesh-canvas');
    await page.locator('#mesh-edges').click();
    await page.locator('#mesh-canvas').focus();
    for (const key of ['ArrowLeft', 'ArrowUp', '+', '-', ']', '[', 'PageDown', 'PageUp', '0']) {
        await changes(page, `${key} on the mesh`, () => page.keyboard.press(key), 'mesh-canvas');
    }
    if (report.domain.dimension === 3) {
        const [kept, of] = await shown(page);
        assert.ok(kept < of);
        await changes(page, 'turning mesh', () => page.locator('#mesh-turn').click(), 'mesh-canvas');
        await page.locator('#mesh-turn').click();
    }
    const details = page.locator('details[data-table="mesh"]');
    const [download] = await Promise.all([page.waitForEvent('download'), (async () => {
        await details.locator('summary').click();
        await details.locator('.csv').click();
    })()]);
    const [head, ...rows] = parse(await readFile(await download.path(), 'utf8'));
    const [kept] = await shown(page);
    assert.equal(rows.length, kept, 'the table has the cells that are kept');
    const at = (name) => head.findIndex((h) => h.startsWith(name));
    for (const row of rows.slice(0, 50)) {
        const c = Number(row[0]);
        assert.deepEqual([row[at('radius')], row[at('smallest')], row[at('size')]].map(Number),
            [report.view.radius_edge[c], report.view.least_angle[c], report.view.size[c]], `cell ${c}`);
        const worker = report.view.owner ? String(report.view.owner[c]) : undefined;
        assert.equal(row[at('worker')], worker, `worker of cell ${c}`);
    }
    await details.locator('summary').click();
    const [png] = await Promise.all([page.waitForEvent('download'), page.locator('#mesh-png').click()]);
    assert.equal((await readFile(await png.path())).subarray(1, 4).toString(), 'PNG');
    await page.locator('#mesh').screenshot({ path: `${shots}/mesh.png` });
    passed += 3;
}

/** Prints the milliseconds of a frame while the mesh turns, with the drawing finished each time. It checks no bound. */
async function frames(page) {
    const times = await page.evaluate(async () => {
        const turn = document.getElementById('mesh-turn');
        const gl = document.getElementById('mesh-canvas').getContext('webgl2');
        const times = [];
        turn.click();
        let last = performance.now();
        for (let i = 0; i < 21; i += 1) {
            await new Promise(requestAnimationFrame);
            gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
            times.push(performance.now() - last);
            last = performance.now();
        }
        turn.click();
        return times.sort((a, b) => a - b);
    });
    console.log(`mesh: ${await page.locator('#mesh-readout').textContent()}: ${times[10].toFixed(0)} ms a frame, at most ${times[20].toFixed(0)}`);
}

/** Tab reaches every control. */
async function keyboard(page) {
    await page.evaluate(() => document.activeElement.blur());
    const wanted = await page.evaluate(() => [...document.querySelectorAll('button, select, input, canvas, summary')]
        .filter((e) => e.checkVisibility() && !e.disabled).length);
    const seen = new Set();
    for (let i = 0; i < 3 * wanted + 60; i += 1) {
        await page.keyboard.press('Tab');
        seen.add(await page.evaluate(() => {
            const e = document.activeElement;
            e.dataset.tab ??= String(Math.random());
            return /^(button|select|input|canvas|summary)$/i.test(e.tagName) ? e.dataset.tab : '';
        }));
    }
    seen.delete('');
    assert.ok(seen.size >= wanted, `Tab reaches ${seen.size} of ${wanted} controls`);
    const unnamed = await page.evaluate(() => [...document.querySelectorAll('button, select, input, canvas')]
        .filter((e) => !(e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.length)).length);
    assert.equal(unnamed, 0, 'controls without a name');
    passed += 1;
}

for (const scheme of ['light', 'dark']) {
    const { page, faults, milliseconds } = await open(scheme);
    const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const first = await ground();
    await page.screenshot({ path: `${shots}/${scheme}.png`, fullPage: true });
    if (scheme === 'light') {
        await widths(page, 'page');
        await figures(page);
        await tables(page);
        if (await page.locator('#details').count()) {
            await data(page);
        }
        if (await page.locator('#canvas').count()) {
            await scene(page);
        }
        if (reportFile) {
            const report = JSON.parse(await readFile(reportFile, 'utf8'));
            await mesh(page, report);
            if (report.domain.dimension === 3) {
                await frames(page);
            }
        }
        await keyboard(page);
        await page.locator('#theme').click();
        await page.locator('#theme').click();
        assert.notEqual(await ground(), first, 'the switch does not darken');
    }
    assert.deepEqual(faults, []);
    console.log(`${scheme}: ready after ${milliseconds} ms`);
    await page.close();
}
await browser.close();
await withoutGraphics();
console.log(`${passed} passed, 0 failed`);
