"""What the page does by itself, in the browser: its title, typed numbers, names cut off."""

from __future__ import annotations

import json
from html import escape
from typing import Final

# viser's number boxes report each key. Of a typed 0.5 the 0 would be taken first. Characters that
# the boxes reject are dropped: 2,5 would be 25.
#
# Here the browser holds what is typed until Enter, or until the box loses the focus. It puts back
# what the box had and hands over the text as it is, in the hidden line of `number_input`. With the
# text go the label of the slider and the time, for an unchanged line is not reported.
#
# Escape drops the text, as does an empty box. The box does not hear that it loses the focus, for it
# would write a number of its own making. Going to a box is reported without a text, since a motion
# that plays would write into it. The page itself gives the focus back to a box whose number comes
# late, which is nobody's going there. If another browser writes into it, what was typed goes on.
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
    """An empty style sheet whose script runs as it is loaded.

    It names the browser's tab, has typed numbers reported once, and shows names that are cut off.
    """
    code = f"document.title = {json.dumps(title)}; (() => {{ {_TYPED} {_KEYS} {_NAMES} }})();"
    return f'<style onload="{escape(code.replace(chr(10), " "), quote=True)}"></style>'
