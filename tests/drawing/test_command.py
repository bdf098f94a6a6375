"""The command, and what is said without Matplotlib."""

import subprocess
import sys

import pytest

from hybrid_dynamics_core import HybridDynamicsError, Robot
from hybrid_dynamics_core.drawing import draw, draw_modes
from hybrid_dynamics_core.drawing.__main__ import main
from hybrid_dynamics_core.errors import MissingPackageError

from .shapes import SHAPES


def test_a_shipped_robot_and_a_file_are_drawn(tmp_path) -> None:
    file = tmp_path / "pendulum.yaml"
    file.write_text(
        f"format: 1\nname: pendulum\nsource: invented\n{SHAPES['pendulum']}", encoding="utf-8"
    )
    main(["type_c", str(tmp_path / "type_c.svg")])
    main([str(file), str(tmp_path / "pendulum.png"), "--names", "all"])
    main(["type_c", str(tmp_path / "modes.svg"), "--modes"])
    assert {path.name for path in tmp_path.iterdir()} == {
        "pendulum.yaml",
        "type_c.svg",
        "pendulum.png",
        "modes.svg",
    }


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["excavatr", "out.svg"], "did you mean 'excavator'?"),
        (["type_c", "out.gif"], "not as '.gif'"),
        (["type_c", "no/such/folder/out.svg"], "No such file or directory"),
    ],
)
def test_mistakes_end_with_one_message(arguments, words, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 1
    message = capsys.readouterr().err
    assert words in message
    assert message.count("\n") == 1


def test_without_matplotlib_the_error_says_what_to_install(forging: Robot, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for function in (draw, draw_modes):
        with pytest.raises(
            MissingPackageError, match=r"pip install matplotlib.*extra 'plot'"
        ) as raised:
            function(forging)
        assert isinstance(raised.value, HybridDynamicsError)
        assert isinstance(raised.value, ImportError)


def test_importing_the_package_does_not_import_matplotlib() -> None:
    text = "import hybrid_dynamics_core.drawing, sys; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", text], check=False).returncode == 0
