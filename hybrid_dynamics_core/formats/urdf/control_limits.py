"""Command limits in <ros2_control>, which hold in addition to those of <limit>."""

from __future__ import annotations

import math

from ...description.document import Data, KeyPath
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader

_BOUNDS = {
    "velocity": "velocity_limit",
    "acceleration": "acceleration_limit",
    "effort": "effort_limit",
    "torque": "effort_limit",
    "force": "effort_limit",
}
_NARROW = "limits of <ros2_control> that leave no range within those of <limit>; left out"


def add_control_limits(xml: XmlReader, element: LocatedElement, name: str, joint: Data) -> None:
    """Narrow the limits of a joint to those of its command interfaces.

    Args:
        xml: the URDF.
        element: the <joint> of a <ros2_control>.
        name: name of the joint.
        joint: entry of the joint in the document.

    Raises:
        DescriptionError: a limit is no number.
    """
    if not _are_enabled(element):
        return
    for interface in element.all("command_interface"):
        kind = interface.get("name")
        path: KeyPath = ("joints", name, _BOUNDS.get(kind, "limits"))
        if not _are_enabled(interface) or (kind != "position" and kind not in _BOUNDS):
            continue
        lower, upper = _range(xml, interface, path)
        if (lower, upper) == (-math.inf, math.inf):
            continue
        xml.locate(path, interface)
        if kind == "position":
            _narrow(xml, interface, name, joint, (lower, upper))
            continue
        bound = min(abs(lower), abs(upper), joint.get(_BOUNDS[kind], math.inf))
        if bound > 0.0:
            joint[_BOUNDS[kind]] = bound


def _narrow(
    xml: XmlReader,
    interface: LocatedElement,
    name: str,
    joint: Data,
    limits: tuple[float, float],
) -> None:
    """Replace limits by their intersection with those of an interface."""
    lower, upper = joint.get("limits", (-math.inf, math.inf))
    narrow = (max(lower, limits[0]), min(upper, limits[1]))
    if not narrow[0] < narrow[1]:
        xml.collect(interface, name, _NARROW)
        return
    joint["limits"] = list(narrow)


def _range(xml: XmlReader, interface: LocatedElement, path: KeyPath) -> tuple[float, float]:
    """Smallest and largest command; infinite if not given."""
    ends = {"min": -math.inf, "max": math.inf}
    for param in interface.all("param"):
        end = param.get("name")
        if end in ends and "inf" not in param.text.lower():
            ends[end] = xml.text_number(param, path, ends[end])
    return ends["min"], ends["max"]


def _are_enabled(element: LocatedElement) -> bool:
    """Whether the limits of a joint or interface are enabled."""
    limits = element.first("limits")
    return limits is None or limits.get("enable").strip().lower() != "false"
