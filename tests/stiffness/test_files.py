"""The section `stiffness` of a file: what is wrong with it in one line, and the way back."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, InputError, load
from hybrid_dynamics_core.export import to_yaml
from hybrid_dynamics_core.stiffness import (
    Beam,
    Bearing,
    DriveStiffness,
    Elasticity,
    LinkMatrix,
    OilColumn,
    Section,
    box_section,
    tube_section,
)
from tests.export.test_round_trip import FORMS, write
from tests.stiffness.machines import CRANE, machine

ALL = (
    CRANE
    + """
  pins:
    lug: {radial: 5e8*N/m, axial: free, tilt: rigid}
    luff: {radial: 4e8, tilt: 1e7*N*m/rad}
  links:
    boom:
      beams:
        - {E: 210e9, G: 81e9, to: lug, tube: {diameter: 120*mm, wall: 8*mm}, z: y}
        - E: 210e9
          G: 81e9
          start: lug
          to: end_effector
          box: {width: 0.1, height: 0.2, wall: 0.01}
    rod: {matrix: <matrix>, at: [0.1, 0, 0]}
"""
)
MATRIX = np.diag([1e8, 2e8, 3e8, 1e6, 2e6, 3e6]).tolist()


@pytest.mark.parametrize("form", ["own", *FORMS])
def test_a_file_comes_back_from_each_format_as_it_was(form, tmp_path):
    robot = machine(ALL, matrix=MATRIX)
    expected = robot.stiffness(robot.close([2.5])).compliance
    if form == "own":
        path = tmp_path / "back.yaml"
        path.write_text(to_yaml(robot))
    else:
        path = write(robot, form, tmp_path)
    back = load(path)
    compliance = back.stiffness(back.close([2.5])).compliance
    scale = np.abs(expected).max()
    np.testing.assert_allclose(compliance, expected, atol=1e-9 * scale)  # loops close to 1e-12


def compliance_of(text: str) -> np.ndarray:
    robot = machine(text)
    return robot.stiffness(robot.close([2.5])).compliance


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("bulk_modulus: 1.2e9", "bulk_modulus: -1.2e9", "oil: bulk_modulus is -1.2e.09 Pa"),
        ("bulk_modulus: 1.2e9", "bulk_modulus: 1.2e9*N/m", "expected .*Pa"),
        ("dead_volume: [1e-3", "dead_volume: [-1e-3", "dead_volume is -0.001 m"),
        ("    cylinder: {oil", "    cilinder: {oil", "did you mean 'cylinder'"),
        ("lug: {radial: 5e8*N/m", "lig: {radial: 5e8*N/m", "did you mean 'lug'"),
        ("radial: 5e8*N/m", "radial: 0", "radial: is 0; expected a stiffness above zero"),
        ("radial: 5e8*N/m", "radial: 5e8*N*m/rad", "N/m"),
        ("    rod: {matrix", "    rot: {matrix", "did you mean 'rod'"),
        ("E: 210e9, G: 81e9, to: lug", "E: 0, G: 81e9, to: lug", "E is 0 Pa"),
        ("to: lug, tube", "to: lag, tube", "did you mean 'lug'"),
        ("to: lug, tube", "to: [0, 0, 0], tube", "beam 1 begins and ends at"),
        ("to: end_effector", "to: lug", "beam 2 begins and ends at"),
        ("start: lug", "start: [1, 1, 1]", "expected the origin of the link, or the end"),
        ("wall: 8*mm", "wall: 80*mm", "wall is 0.08 m; expected at most the radius"),
        (", tube: {diameter: 120*mm, wall: 8*mm}", "", "gives none of section, tube, box"),
        ("2000000.0, 0.0]", "2000000.0, 7.0]", "not symmetric"),
        ("3000000.0]", "-3000000.0]", "negative entry on its diagonal"),
        ("cylinder: {oil", "luff: {oil", "joint 'luff' has no drive"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(old, new, says):
    text = ALL.replace("<matrix>", str(MATRIX))
    assert old in text
    with pytest.raises((DescriptionError, InputError), match=says) as caught:
        compliance_of(text.replace(old, new, 1))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Elasticity(drives={"q": -1.0}), "drives: q: stiffness is -1"),
        (lambda: Elasticity(drives={"q": "soft"}), "drives: q: .*expected a number"),
        (lambda: Elasticity(pins={"q": 1e6}), "expected a Bearing"),
        (lambda: Elasticity(links={"q": 1e6}), "expected a LinkMatrix, or Beams"),
        (Bearing, "has no stiffness"),
        (lambda: Bearing(radial=-1.0), "radial is -1 N/m"),
        (lambda: Bearing(radial=1.0, matrix=np.eye(6)), "gives a matrix and radial"),
        (lambda: Bearing(matrix=np.eye(6) - 2.0 * np.eye(6)[::-1]), "indefinite"),
        (lambda: LinkMatrix(np.diag([1.0] * 5 + [0.0])), "singular"),
        (lambda: LinkMatrix(np.full((6, 6), np.nan)), "expected 6 x 6 finite numbers"),
        (lambda: DriveStiffness(np.nan), "expected a stiffness above zero"),
        (lambda: OilColumn(np.inf), "bulk_modulus is inf Pa"),
        (lambda: Section(0.0, 1.0, 1.0, 1.0), "A is 0 m"),
        (lambda: Beam(1.0, 1.0, tube_section(1.0, 0.1), [0, 0]), "expected 3 finite numbers"),
        (lambda: Beam(1.0, 1.0, tube_section(1.0, 0.1), "tip", z=[0, 0, 0]), "no length"),
        (lambda: box_section(0.1, 0.1, 0.05), "less than half"),
    ],
)
def test_impossible_data_are_refused(make, says):
    with pytest.raises(InputError, match=says):
        make()


def test_what_cannot_be_answered_is_told():
    robot = load("excavator")
    state = robot.close(robot.reference)
    soft = Elasticity(drives={"slew": 1e7})
    with pytest.raises(InputError, match="nothing of the robot is elastic"):
        robot.stiffness(state)
    with pytest.raises(InputError, match="expected Elasticity"):
        robot.stiffness(state, {"slew": 1e7})
    with pytest.raises(InputError, match="no batch"):
        robot.stiffness(robot.close(np.tile(robot.reference, (2, 1))), soft)
    with pytest.raises(InputError, match="did you mean 'bucket'"):
        robot.stiffness(state, soft, "buket")
    with pytest.raises(InputError, match="the joint moves about z"):
        robot.stiffness(state, Elasticity(pins={"slew": Bearing(turn=1e6)}))
    with pytest.raises(InputError, match="along z it is free"):
        robot.stiffness(state, Elasticity(pins={"slew": Bearing(axial=0.0)}))
    with pytest.raises(InputError, match="has oil but no cylinder"):
        robot.stiffness(state, Elasticity(drives={"slew": DriveStiffness(oil=OilColumn(1e9))}))
