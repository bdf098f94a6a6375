"""The page's own script: title, typed numbers, truncated names."""

from __future__ import annotations

import json
from html import escape
from typing import Final

# viser's number boxes report each key, so that 0.5 would first be 0. They drop characters that they
# reject, so that 2,5 would be 25.
#
# This script keeps typed text until Enter, or until the box loses the focus. Then it restores the
# box, and passes the text on through the hidden field of `number_input`. It adds the label of the
# slider, and the time, since an unchanged field is not reported.
#
# Escape, or an empty box, drops the text. The box gets no blur event, since it would then write a
# number of its own. A focus is reported without a text, since a playing motion would write into the
# box. A focus that the page itself restores is not reported. If another browser writes into the
# box, typed text is kept.
_TYPED: Final = """
if (window.hybridDynamicsTyped) return;
window.hybridDynamicsTyped = true;
let held = null, before = '', typed = '', typedIn = null, byTab = false;
const boxes = 'div:has(> .mantine-Slider-root) .mantine-NumberInput-input';
const own = event => event.target instanceof HTMLInputElement && event.target.matches(boxes);
const write = (box, text) =>
  Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set.call(box, text);
const labelOf = part => part.querySelector('label')?.textContent ?? labelOf(part.parentElement);
const drop = () => {
  write(held, before);
  held = null;
};
const send = (box, text) => {
  const line = document.querySelector('div:has(> .hd-sheet) + div input');
  write(line, JSON.stringify([labelOf(box), text, Date.now()]));
  line.dispatchEvent(new Event('input', {bubbles: true}));
};
const tell = () => {
  const box = held;
  drop();
  if (typed.trim()) send(box, typed);
};
document.addEventListener('pointerdown', event => {
  if (own(event)) send(event.target, null);
}, true);
document.addEventListener('keydown', event => { byTab = event.key === 'Tab'; }, true);
document.addEventListener('focusin', event => {
  if (own(event) && byTab) send(event.target, null);
  byTab = false;
}, true);
document.addEventListener('beforeinput', event => {
  if (!own(event)) return;
  const box = event.target;
  if (held !== box) before = box.value;
  else if (box.value !== typed) {
    before = box.value;
    write(box, typed);
    box.setSelectionRange(typed.length, typed.length);
  }
}, true);
document.addEventListener('input', event => {
  if (!event.isTrusted || !own(event)) return;
  held = typedIn = event.target;
  typed = held.value;
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
# Arrow keys that move a slider must not turn the camera, which viser has them do as well. React
# hears of keys below.
_KEYS: Final = """
document.body.addEventListener('keydown', event => {
  if (event.target.matches('[role=slider]')) event.stopPropagation();
});
"""
_NAMES: Final = """
document.addEventListener('mouseover', event => {
  if (event.target.matches?.('.mantine-Select-input')) event.target.title = event.target.value;
}, true);
"""


def script_html(title: str) -> str:
    """An empty style sheet whose script runs when it is loaded.

    The script sets the title, reports typed numbers once, and shows truncated names in full.
    """
    code = f"document.title = {json.dumps(title)}; (() => {{ {_TYPED} {_KEYS} {_NAMES} }})();"
    return f'<style onload="{escape(code.replace(chr(10), " "), quote=True)}"></style>'
