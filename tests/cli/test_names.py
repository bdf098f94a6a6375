"""Names with / - . and leading digits in every verb: options, tables, pictures, JSON and bags."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.calling import call, call_line, data_of
from tests.export.test_names import PUBLISHED, TEXT

U = "arm/slide=0.1,j_1/=30*deg"
DU = "arm/slide=-0.1,j_1/=0.3"


@pytest.fixture
def arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("arm.yaml").write_text(TEXT.format(*PUBLISHED))
    return "arm.yaml"


def test_options_take_names_and_json_has_them(arm: str) -> None:
    pose = data_of("fk", arm, "-u", U, "--du", DU, "--frame", "left.hand")
    assert pose["coordinates"]["arm/slide"] == pytest.approx(0.1)
    assert pose["coordinates"]["j_1/"] == pytest.approx(0.5235987755982988)
    assert pose["rates"]["j_1/"] == pytest.approx(0.3)
    tau = data_of("id", arm, "-u", U, "--du", DU, "--ddu", "j_1/=0.3")["tau"]
    efforts = ",".join(f"{name}={effort!r}" for name, effort in tau.items())
    back = data_of("fd", arm, "-u", U, "--du", DU, "--tau", efforts)
    assert back["ddu"] == {"arm/slide": pytest.approx(0.0, abs=1e-9), "j_1/": pytest.approx(0.3)}
    end = data_of("simulate", arm, "-u", U, "--tau", "weight", "--seconds", "0.05")["u"]
    assert end["arm/slide"] == pytest.approx(0.1, abs=1e-3)
    reach = call("workspace", arm, "--samples", "50", "--range", "arm/slide=0.1:0.2", "--json")
    assert reach.exit_code == 0
    assert call("workspace", arm, "--samples", "50", "--range", "arm=0:1").exit_code == 2
    named = data_of("info", arm)
    assert "2nd" in named["links"]


def test_pictures_and_tables_have_the_names(arm: str) -> None:
    for line in (
        f"check {arm} --draw arm.svg --names all",
        f"branches {arm} --draw modes.svg",
        f"workspace {arm} --samples 50 --over arm/slide,j_1/ --draw map.svg",
        f"simulate {arm} --seconds 0.05 --save fall.csv --draw fall.svg",
    ):
        answer = call_line(line)
        assert answer.exit_code == 0, answer.output
    head = Path("fall.csv").read_text().splitlines()[0].split(",")
    assert {"arm/slide", "j_1/.velocity", "1/q", "a-b-c.velocity"} <= set(head)
    assert 'id="joint:arm/q-1"' in Path("arm.svg").read_text()


def test_bags_take_the_names(arm: str) -> None:
    pytest.importorskip("rosbags")
    settings = "hybrid_dynamics_node:\n  ros__parameters:\n    sensors:\n"
    settings += "      arm/slide: {offset: 0.001}\n      j_1/: {sign: -1}\n"
    Path("node.yaml").write_text(settings)
    for line in (
        f"simulate {arm} --seconds 0.5 --tau weight --du {DU} --save run.csv",
        f"bag make given --robot {arm} --trajectory run.csv",
        f"bag process given out --robot {arm} --params node.yaml",
        "bag report out --output page.html",
        "bag export out tables",
    ):
        answer = call_line(line)
        assert answer.exit_code == 0, answer.output
    table = Path("tables/hybrid_dynamics.required_efforts.csv").read_text()
    assert "arm/slide" in table


def test_no_name_is_missing_in_a_legend(arm: str) -> None:
    """Matplotlib leaves out labels that begin with an underscore."""
    pytest.importorskip("matplotlib")
    from hybrid_dynamics_core import load
    from hybrid_dynamics_core.drawing import draw_simulation
    from hybrid_dynamics_core.simulation import simulate

    Path(arm).write_text(Path(arm).read_text().replace("j_1/", "_wrist"))
    robot = load(arm)
    motion = simulate(robot, robot.close(robot.reference), tau=[0, 0], t_span=(0, 0.1))
    figure = draw_simulation(robot, motion)
    legends = [axes.get_legend() for axes in figure.axes]
    texts = {text.get_text().strip() for legend in legends for text in legend.get_texts()}
    assert "_wrist" in texts
