// The theme: light, dark, or the preference of the system. Listeners are called after every change.
const states = ['system', 'light', 'dark'];
const listeners = [];
const system = window.matchMedia('(prefers-color-scheme: dark)');
let state = 'system';

export function isDark() {
    return state === 'dark' || (state === 'system' && system.matches);
}

export function onTheme(listener) {
    listeners.push(listener);
}

function notify() {
    for (const listener of listeners) {
        listener(isDark());
    }
}

export function startTheme(button) {
    button.addEventListener('click', () => {
        state = states[(states.indexOf(state) + 1) % states.length];
        if (state === 'system') {
            delete document.documentElement.dataset.theme;
        } else {
            document.documentElement.dataset.theme = state;
        }
        button.textContent = `Theme: ${state}`;
        notify();
    });
    system.addEventListener('change', notify);
}
