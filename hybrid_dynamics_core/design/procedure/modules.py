"""Parallel modules from templates, one on the platform of the other."""

from __future__ import annotations

from typing import Any

from ...description.expand.templates import Template, shipped_template, shipped_templates
from ...errors import InputError
from ...ground.suggestions import no_such_name
from .arm import UPRIGHT, Arm
from .phrases import Phrase, parse_phrases

_DRIVEN = ("lambda_<leg>", "theta_<leg>")  # joints of legs that have drives
_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def add_modules(arm: Arm, text: str) -> None:
    """Add modules, each on the platform of the one before, and their drives.

    Args:
        arm: the arm that they carry.
        text: `3-UPU: base_radius=0.4 platform_radius=0.2 height=0.6; 3-UPS/S: ...`

    Raises:
        InputError: there is no such template, or a parameter is unknown or missing.
    """
    used = 0
    for number, phrase in enumerate(parse_phrases("module", text), start=1):
        if phrase.head not in shipped_templates():
            problem = no_such_name("template", phrase.head, shipped_templates())
            raise InputError(f"{phrase.place}: {problem}")
        template = shipped_template(phrase.head)
        legs = template.data["legs"]
        count = len(legs["labels"])
        labels = list(_LETTERS[used : used + count])
        if len(labels) < count:
            raise InputError(f"{phrase.place}: there are more than {len(_LETTERS)} legs")
        used += count
        name = f"m{number}"
        parameters = _parameters(phrase, template, count)
        entry: dict[str, Any] = {"template": phrase.head, "on": arm.tip, "legs": labels}
        arm.data["modules"][name] = {**entry, "parameters": parameters}
        pattern = next(joint for joint in _DRIVEN if joint in legs["joints"])
        arm.data["active"] += [pattern.replace("<leg>", label) for label in labels]
        arm.tip = f"{name}_platform"
        arm.frames[arm.tip] = UPRIGHT
        arm.lengths[arm.tip] = 0.0
        arm.pitches[arm.tip] = 0.0


def _parameters(phrase: Phrase, template: Template, count: int) -> dict[str, Any]:
    """The parameters of a module; those of legs are one number, or one for each."""
    once = template.data["parameters"]
    of_legs = template.data["legs"].get("parameters", {})
    parameters = {**once, **of_legs}
    needed = [name for name, about in parameters.items() if "default" not in about]
    phrase.require_keys(tuple(parameters), needed)
    values: dict[str, Any] = {}
    for key, text in phrase.words.items():
        terms = text.split(",")
        if len(terms) > 1 and (key not in of_legs or len(terms) != count):
            raise InputError(f"{phrase.place}: {key} is '{text}'; expected one number")
        values[key] = terms if len(terms) > 1 else text
    return values
