// Colours of cells by their quantities and names, and the keys that explain the colours.
import { Color } from 'three';
import { many } from 'septet/layers';

const STEPS = {
    light: ['#fdf5cf', '#e3eab1', '#b9dba6', '#85c8a6', '#4fb0aa', '#2a93ac', '#2172a3', '#27508d', '#252c67'],
    dark: ['#1d2b4f', '#213f74', '#215a8c', '#207797', '#2c9499', '#4fb093', '#86c989', '#c3de88', '#fdf3a6'],
};
// Above this ratio of the largest to the smallest value, a scale is logarithmic.
const WIDE = 20;
const MOST_NAMED = 12;

/** Formats a number for the key. */
export function short(x) {
    return String(Number(x.toPrecision(4)));
}

/** Colours of numbers on a scale between the smallest and the largest. */
class Numbers {
    constructor(values, unit, maybeLog) {
        this.values = values;
        this.unit = unit;
        const known = values.filter((v) => v !== null);
        this.low = known.reduce((a, b) => Math.min(a, b), Infinity);
        this.high = known.reduce((a, b) => Math.max(a, b), -Infinity);
        this.log = maybeLog && this.low > 0 && this.high / this.low > WIDE;
    }

    /** Returns the value at a position of the scale, from 0 to 1. */
    value(part) {
        return this.log ? this.low * (this.high / this.low) ** part : this.low + part * (this.high - this.low);
    }

    /** Returns the position of a value on the scale, from 0 to 1. An unknown value is at its end. */
    part(value) {
        if (value === null || this.high === this.low) {
            return value === null ? 1 : 0;
        }
        return this.log ? Math.log(value / this.low) / Math.log(this.high / this.low) : (value - this.low) / (this.high - this.low);
    }

    paint(tints, dark) {
        const stops = STEPS[dark ? 'dark' : 'light'].map((name) => new Color(name));
        this.values.forEach((value, i) => {
            const at = Math.min(1, Math.max(0, this.part(value))) * (stops.length - 1);
            const step = Math.min(stops.length - 2, Math.floor(at));
            const [a, b] = [stops[step], stops[step + 1]];
            tints[3 * i] = a.r + (at - step) * (b.r - a.r);
            tints[3 * i + 1] = a.g + (at - step) * (b.g - a.g);
            tints[3 * i + 2] = a.b + (at - step) * (b.b - a.b);
        });
    }

    key(dark) {
        const scale = document.createElement('div');
        scale.className = 'scale';
        const bar = document.createElement('div');
        bar.className = 'bar';
        bar.style.background = `linear-gradient(to right, ${STEPS[dark ? 'dark' : 'light'].join(', ')})`;
        const ticks = document.createElement('div');
        ticks.className = 'ticks';
        const parts = this.low === this.high ? [0] : [0, 0.25, 0.5, 0.75, 1];
        ticks.append(...parts.map((part) => {
            const tick = document.createElement('span');
            const value = part === 1 ? this.high : this.value(part);
            [tick.textContent, tick.dataset.value] = [short(value), String(value)];
            return tick;
        }));
        const note = document.createElement('div');
        note.textContent = `${this.unit}${this.log ? ', logarithmic' : ''}`;
        scale.append(bar, ticks, note);
        return [scale];
    }

    /** Describes the range of the values of the kept cells. */
    describe(kept) {
        let [low, high] = [Infinity, -Infinity];
        this.values.forEach((value, i) => {
            if (kept[i] && value !== null) {
                low = Math.min(low, value);
                high = Math.max(high, value);
            }
        });
        return low <= high ? `${this.unit} from ${short(low)} to ${short(high)}` : '';
    }
}

/** Colours of names, such as regions and workers. */
class Names {
    constructor(values, name, all) {
        this.values = values;
        this.name = name;
        this.all = all;
        this.counts = new Map();
        for (const value of [...values].sort((a, b) => a - b)) {
            this.counts.set(value, (this.counts.get(value) ?? 0) + 1);
        }
    }

    paint(tints, dark) {
        const colours = new Map([...this.counts.keys()].map((value) => [value, many(value, dark)]));
        this.values.forEach((value, i) => {
            const { r, g, b } = colours.get(value);
            tints.set([r, g, b], 3 * i);
        });
    }

    key(dark) {
        const list = document.createElement('ul');
        list.className = 'key';
        const rows = [...this.counts].slice(0, MOST_NAMED).map(([value, count]) => {
            const item = document.createElement('li');
            const swatch = document.createElement('span');
            swatch.className = 'swatch';
            swatch.style.background = many(value, dark).getStyle();
            [item.dataset.value, item.dataset.count] = [String(this.name(value)), String(count)];
            item.append(swatch, `${this.name(value)}: ${count} cells`);
            return item;
        });
        list.append(...rows);
        if (this.counts.size > MOST_NAMED) {
            const more = document.createElement('li');
            more.textContent = `and ${this.counts.size - MOST_NAMED} more`;
            list.append(more);
        }
        return [list];
    }

    describe(kept) {
        const seen = new Set(this.values.filter((_, i) => kept[i])).size;
        return `${seen} of ${this.counts.size} ${this.all}`;
    }
}

/** Returns the scale of each quantity by which cells can be coloured. */
export function scalesOf(mesh) {
    const angle = mesh.dimension === 3 ? 'smallest dihedral angle' : 'smallest angle';
    return {
        radius_edge: new Numbers(mesh.radius_edge, 'radius-edge ratio', true),
        least_angle: new Numbers(mesh.least_angle, `${angle} [degrees]`, false),
        size: new Numbers(mesh.size, 'size f at the centre', true),
        region: new Names(mesh.region, (i) => `region ${mesh.regions[i]}`, 'regions'),
        ...(mesh.owner ? { owner: new Names(mesh.owner, (p) => `worker ${p}`, 'workers') } : {}),
    };
}
