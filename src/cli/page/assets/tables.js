// Tables under the pictures, which are made when they are opened, and complete tables as CSV.
const MOST_ROWS = 500;

/** Formats a value for CSV, with quotes if it needs them. */
function quoted(value) {
    const text = value === null || value === undefined ? '' : String(value);
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

export function csv(table) {
    return [table.columns, ...table.rows].map((row) => row.map(quoted).join(',')).join('\r\n') + '\r\n';
}

function row(values, tag) {
    const tr = document.createElement('tr');
    for (const value of values) {
        const cell = document.createElement(tag);
        if (tag === 'th') {
            cell.scope = 'col';
        }
        const number = typeof value === 'number' && !Number.isInteger(value);
        cell.textContent = number ? Number(value.toPrecision(6)) : (value ?? '–');
        tr.append(cell);
    }
    return tr;
}

function fill(place, table) {
    const element = document.createElement('table');
    element.createTHead().append(row(table.columns, 'th'));
    const body = element.createTBody();
    body.append(...table.rows.slice(0, MOST_ROWS).map((values) => row(values, 'td')));
    place.replaceChildren(element);
    if (table.rows.length > MOST_ROWS) {
        const note = document.createElement('p');
        note.textContent = `The first ${MOST_ROWS} of ${table.rows.length} rows; the CSV has all.`;
        place.append(note);
    }
}

function download(name, text) {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([text], { type: 'text/csv' }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Shows the table that `current` returns in its place. Returns a function that refreshes it. */
export function tie(details, current) {
    const place = details.querySelector('.rows');
    const refresh = () => {
        if (details.open) {
            fill(place, current());
        }
    };
    details.addEventListener('toggle', refresh);
    details.querySelector('.csv').addEventListener('click', () => {
        download(`${details.dataset.table}.csv`, csv(current()));
    });
    return refresh;
}
