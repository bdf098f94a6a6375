"""Masses of bodies, as MuJoCo computes them from <inertial> and shapes."""

from __future__ import annotations

import numpy as np

from ...description.document import Data
from ...ground.arrays import Array
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .compiler.compiled import Body

NEGLIGIBLE = 1e-9  # [kg, kg m^2] counts as zero, since MuJoCo requires a mass of moving bodies
_SAME = 1e-9  # relative
_RAISED = NEGLIGIBLE * (1.0 + 1e-6)  # a body that is raised by no more has what is written


def mass_entry(body: Body, name: str, xml: XmlReader, element: LocatedElement) -> Data:
    """Mass, centre of mass and inertia of a body; empty if they count as zero.

    Args:
        body: a body that moves or has an <inertial>.
        name: name of its link.
        xml: collects notes.
        element: element of the body.

    Raises:
        DescriptionError: a number is not finite.
    """
    inertia = np.array(body.inertia)
    numbers = np.concatenate([[body.mass], body.com, inertia.ravel()])
    if not np.isfinite(numbers).all():
        problem = f"has a mass of {body.mass:g} kg or moments that are not finite"
        raise xml.error(element, ("links", name), problem)
    moments = np.linalg.eigvalsh(inertia)
    if body.mass <= NEGLIGIBLE and moments[-1] <= NEGLIGIBLE:
        return {}
    if body.is_from_shapes:
        xml.note(element, f"body {name} has the mass of its shapes: {body.mass:.6g} kg")
    elif body.written and not _is_as_written(body, moments):
        xml.note(element, f"body {name} is scaled, raised or balanced, as <compiler> says")
    return {"mass": body.mass, "com": list(body.com), "inertia": inertia.tolist()}


def _is_as_written(body: Body, moments: Array) -> bool:
    """Whether a body has the mass and principal moments of its <inertial>."""
    mass, *written = body.written
    apart = float(np.abs(moments - written).max())
    allowed = max(_SAME * float(np.abs(moments).max()), _RAISED)
    return apart <= allowed and abs(body.mass - mass) <= max(_SAME * body.mass, _RAISED)
