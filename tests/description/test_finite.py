"""What is not finite is told as that, with its line, in every place of every format."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, load
from hybrid_dynamics_core.export import to_mjcf, to_sdf, to_urdf_plus
from tests.description.robots import parse
from tests.description.test_units import ARM, VALUES
from tests.robots import robot
from tests.sampling import examples

NOT_FINITE = [".nan", ".NaN", ".inf", "-.inf", "1e308*10", "1e308*10 - 1e308*10"]
ENDLESS = ("angle", "upper", "turning", "torque", "sliding", "force")  # none, where infinite


@examples(150)
@given(st.sampled_from(sorted(VALUES)), st.sampled_from(NOT_FINITE))
def test_a_value_of_a_file_that_is_not_finite(name: str, written: str) -> None:
    if name in ENDLESS and "nan" not in written.lower() and " - " not in written:
        written = ".nan"
    numbers = {key: repr(value) for key, (value, _) in VALUES.items()}
    with pytest.raises(DescriptionError, match="not finite") as caught:
        parse(ARM.format(**{**numbers, name: written}))
    assert caught.value.line is not None
    assert caught.value.key


def test_limits_that_are_no_numbers() -> None:
    numbers = {key: repr(value) for key, (value, _) in VALUES.items()}
    words = (
        r"small\.yaml:12: joints\.q1\.limits\[0\]: is nan, which is not finite; expected a number"
    )
    with pytest.raises(DescriptionError, match=words):
        parse(ARM.format(**{**numbers, "angle": ".nan"}))


@pytest.mark.parametrize("form", ["urdf", "sdf", "xml"])
@pytest.mark.parametrize("word", ["nan", "NaN", "inf", "-inf"])
def test_numbers_of_other_formats(tmp_path: Path, form: str, word: str) -> None:
    """The number at which most files of others go wrong: a mass."""
    arm = robot("five_bar")
    text = {"urdf": to_urdf_plus, "sdf": to_sdf, "xml": to_mjcf}[form](arm)
    before = {"urdf": '<mass value="', "sdf": "<mass>", "xml": r'<inertial [^>]*mass="'}[form]
    found = re.search(rf'({before})([^"<]+)', text)
    assert found is not None
    path = tmp_path / f"arm.{form}"
    path.write_text(text[: found.start(2)] + word + text[found.end(2) :])
    with pytest.raises(DescriptionError, match="which is not finite") as caught:
        load(path)
    assert caught.value.line == text[: found.start()].count("\n") + 1
