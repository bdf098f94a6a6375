"""What the page does by itself, in the browser: its title, and numbers that are typed."""

from __future__ import annotations

import json
from html import escape
from typing import Final

# viser's number boxes tell each key: of a typed 0.5 the 0 would be taken first. Here the browser keeps what is typed
# until Enter, or until the box is left, and viser hears of it once. Escape gives it up. A box that is left is not told
# so, for it would then put a number beyond the slider's end onto that end, which nobody has asked for. The box compares
# what it had with what it gets, by where the cursor was and is: it is shown one change, of all that it had.
_TYPED: Final = """
if (window.hybridDynamicsTyped) return;
window.hybridDynamicsTyped = true;
let held = null, before = '', typedIn = null;
const own = event => event.target instanceof HTMLInputElement && event.target.matches('.mantine-NumberInput-input');
const write = (box, text) => Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set.call(box, text);
const drop = () => {
  write(held, before);
  held = null;
};
const tell = () => {
  const box = held, typed = held.value;
  drop();
  if (!/[0-9]/.test(typed)) return;
  box.setSelectionRange(0, before.length);
  box.dispatchEvent(new KeyboardEvent('keydown', {bubbles: true, key: 'Unidentified'}));
  write(box, typed);
  box.setSelectionRange(typed.length, typed.length);
  box.dispatchEvent(new Event('input', {bubbles: true}));
};
document.addEventListener('beforeinput', event => {
  if (own(event) && held !== event.target) before = event.target.value;
}, true);
document.addEventListener('input', event => {
  if (!event.isTrusted || !own(event)) return;
  held = typedIn = event.target;
  event.stopImmediatePropagation();
}, true);
document.addEventListener('keydown', event => {
  if (held !== event.target) return;
  if (event.key === 'Enter') tell();
  if (event.key === 'Escape') drop();
}, true);
for (const leaving of ['change', 'focusout']) document.addEventListener(leaving, event => {
  if (typedIn !== event.target) return;
  event.stopImmediatePropagation();
  if (leaving === 'focusout') typedIn = null;
  if (held) tell();
}, true);
"""


def script_html(title: str) -> str:
    """An empty style sheet that names the browser's tab as it is loaded, and has typed numbers told once."""
    code = f"document.title = {json.dumps(title)}; (() => {{ {_TYPED} }})();"
    return f'<style onload="{escape(code.replace(chr(10), " "), quote=True)}"></style>'
