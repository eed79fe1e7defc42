// A page of `septet report` in headless Chromium: nothing is fetched, nothing complains, every control works,
// pictures are not blank, tables download as CSV that parses, keys do what they say.
//
//     node check.mjs PAGE.html SCREENSHOTS
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const [file, shots] = process.argv.slice(2);
const browser = await chromium.launch({
    executablePath: process.env.SEPTET_CHROMIUM ?? '/usr/bin/chromium',
    args: [
        '--headless', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
        '--disable-background-networking', '--disable-component-update', '--disable-sync', '--no-first-run',
    ],
});
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

async function open(colorScheme) {
    const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, colorScheme, acceptDownloads: true });
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
async function look(page) {
    return page.evaluate(async () => {
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        const canvas = document.getElementById('canvas');
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
    });
}

async function changes(page, what, act) {
    await look(page);
    await act();
    const { changed } = await look(page);
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

async function scene(page) {
    const flat = !(await page.locator('#turn').isVisible());
    assert.ok((await look(page)).colours > 20, 'a blank picture');
    const deepest = Number(await page.locator('#level').getAttribute('max'));
    assert.ok(deepest > 0);
    await changes(page, 'level', () => page.locator('#level-down').click());
    await changes(page, 'level', () => page.locator('#level-up').click());
    for (const colour of ['owner', 'node', 'proof', 'side']) {
        await changes(page, `colour by ${colour}`, () => page.locator('#colour').selectOption(colour));
    }
    for (const id of ['points', 'sets', 'separators']) {
        await changes(page, id, () => page.locator(`#show-${id}`).click());
        await changes(page, id, () => page.locator(`#show-${id}`).click());
    }
    await page.locator('#level-down').click();
    await changes(page, 'upper', () => page.locator('#show-upper').click());
    await page.locator('#show-upper').click();
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
    for (const key of ['ArrowLeft', 'ArrowUp', '+', '-', 'PageDown', 'PageUp', '[', ']']) {
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
        await figures(page);
        await tables(page);
        if (await page.locator('#canvas').count()) {
            await scene(page);
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
console.log(`${passed} passed, 0 failed`);
