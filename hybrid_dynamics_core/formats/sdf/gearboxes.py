"""Gearboxes of SDFormat: two links turn relative to a third one in a constant ratio.

theta_2 = -ratio theta_1. theta_1 is the angle of the parent link relative to the reference body
about <axis>. theta_2 is that of the child link about <axis2>.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...description.document import Data
from ...description.followers import mimic_entry
from ...errors import DescriptionError
from ...ground.arrays import Array
from ..xml.reader import XmlReader
from .joints import LIMITS, JointReader
from .poses import ModelPoses

GEARBOX = "gearbox"
_HINGES = ("revolute", "continuous")
_PARALLEL = 1e-3  # largest difference of equal unit vectors, in files with rounded angles


class GearboxReader:
    """Reader of joints of type gearbox, after all others.

    Args:
        xml: the file, with links and joints already in the document.
        poses: poses of the model.
        joints: all other joints of the model.
    """

    def __init__(self, xml: XmlReader, poses: ModelPoses, joints: Sequence[JointReader]) -> None:
        self.xml = xml
        self.poses = poses
        self.hinges = [joint for joint in joints if joint.type in _HINGES]

    def add(self, gearbox: JointReader) -> None:
        """Make the hinge of the child a follower of that of the parent.

        Raises:
            DescriptionError: one of the links has no hinge on the reference body.
        """
        effects = [key for key in gearbox.constraints() if key not in LIMITS]
        if effects:
            raise self._error(gearbox, f"has {' and '.join(effects)}; give it to a hinge")
        element = gearbox.element.first("gearbox_reference_body")
        if element is None or not element.text.strip():
            raise self._error(gearbox, "has no <gearbox_reference_body>")
        reference = self.poses.link_of(element.text.strip(), gearbox.element)
        ratio = self.xml.text_number(
            gearbox.element.first("gearbox_ratio"), (*gearbox.path, "gearbox_ratio"), 1.0
        )
        leader, sign = self._hinge(gearbox, gearbox.parent(), reference, "axis")
        follower, other_sign = self._hinge(gearbox, gearbox.child(), reference, "axis2")
        if not ratio:
            raise self._error(gearbox, "has a ratio of 0, which holds its child")
        multiplier = -ratio * sign * other_sign
        joints: Data = self.xml.document.section("joints")
        if "mimic" in joints[follower]:
            leader, follower, multiplier = follower, leader, 1.0 / multiplier
        if "mimic" in joints[follower]:
            raise self._error(gearbox, f"ties {leader} and {follower}, which follow others already")
        joints[follower]["mimic"] = mimic_entry({leader: multiplier}, 0.0)
        self.xml.locate(("joints", follower, "mimic"), gearbox.element)
        text = f"gearbox {gearbox.name}: joint {follower} follows {leader}, times {multiplier:g}"
        self.xml.note(gearbox.element, text)

    def _hinge(
        self, gearbox: JointReader, link: str, reference: str, tag: str
    ) -> tuple[str, float]:
        """The hinge between a link and the reference body, and the sign of its coordinate."""
        about = self._in_model(gearbox, tag)
        joints: Data = self.xml.document.section("joints")
        for hinge in self.hinges:
            if {hinge.parent(), hinge.child()} != {link, reference} or hinge.name not in joints:
                continue
            axis = self._in_model(hinge)
            direction = 1.0 if hinge.child() == link else -1.0
            if np.abs(axis - about).max() < _PARALLEL:
                return hinge.name, direction
            if np.abs(axis + about).max() < _PARALLEL:
                return hinge.name, -direction
        problem = (
            f"expected a hinge about its <{tag}> between '{link}' and the reference body"
            f" '{reference}'"
        )
        raise self._error(gearbox, problem)

    def _in_model(self, joint: JointReader, tag: str = "axis") -> Array:
        """An axis (3,) of a joint in the frame of the model."""
        turned: Array = self.poses.joint(joint.element).rotation @ joint.axis(tag)
        return turned

    def _error(self, gearbox: JointReader, problem: str) -> DescriptionError:
        return self.xml.error(gearbox.element, gearbox.path, problem)
