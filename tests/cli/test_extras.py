"""Verbs whose extras are missing say what to install, and do not trace."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.sampling import swept

WITHOUT = """
import sys
sys.modules[{module!r}] = None
from hybrid_dynamics_cli.__main__ import main
sys.argv = ["hybrid-dynamics", *{arguments!r}]
main()
"""


@pytest.mark.parametrize(
    ("module", "arguments", "words"),
    swept(
        [
            ("click", ["--help"], "pip install click"),
            ("rosbags", ["bag", "--help"], "hybrid-dynamics-ros[bag]"),
            ("rosbags", ["bag", "report", "results"], "hybrid-dynamics-ros[bag]"),
            ("viser", ["view", "five_bar"], "pip install viser"),
            ("rosbags", ["view", "five_bar", "--bag", "."], "hybrid-dynamics-ros[bag]"),
            (
                "matplotlib",
                ["check", "five_bar", "--draw", "five_bar.png"],
                "pip install matplotlib",
            ),
        ],
        ("click", "viser"),
    ),
)
def test_what_is_missing_is_named(module: str, arguments: list[str], words: str) -> None:
    code = WITHOUT.format(module=module, arguments=arguments)
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert answer.returncode == 1
    assert words in answer.stderr
    assert "Traceback" not in answer.stderr
