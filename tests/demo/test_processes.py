"""The processes of the demo."""

import time

import pytest

from hybrid_dynamics_ros.demo.errors import DemoError
from hybrid_dynamics_ros.demo.play.processes import child


def test_a_child_that_fails_is_reported_with_its_last_words(tmp_path):
    with child("helper", tmp_path / "log", "no_such_module") as process:
        while process.running:
            time.sleep(0.01)
        with pytest.raises(DemoError, match=r"(?s)helper ended with exit code 1.*no_such_module"):
            process.require_alive()


def test_a_child_ends_with_the_block(tmp_path):
    with child("server", tmp_path / "log", "http.server", "0") as process:
        assert process.running
    assert not process.running


def test_a_child_that_ended_well_is_no_failure(tmp_path):
    with child("printer", tmp_path / "log", "this") as process:
        while process.running:
            time.sleep(0.01)
        process.require_alive()
        assert "Zen of Python" in process.said()
