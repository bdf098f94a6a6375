"""The verb `view`: mistakes of the command line, trajectories and recordings."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner, Result

from hybrid_dynamics_cli.app import app
from hybrid_dynamics_cli.bags.common import LOST
from hybrid_dynamics_cli.verbs.view import acceleration_note, what_to_show
from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.simulation import simulate
from hybrid_dynamics_core.view.session import ViewSession
from tests.sampling import swept

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.usefixtures("needs_viser")


def call(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["view", *arguments, "--no-browser"])


def swing(robot: Robot) -> tuple[np.ndarray, JointTrajectory]:
    """Times and a second of motion."""
    end = robot.reference + np.array([0.4, 0.1, -0.05, 0.3])
    return np.linspace(0.0, 1.0, 101), JointTrajectory.between(robot.reference, end, 1.0)


def test_mistakes_are_reported(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time,q1\n0,0\n1,1\n", encoding="utf-8")
    (tmp_path / "bag").mkdir()
    file, bag = str(tmp_path / "a.csv"), str(tmp_path / "bag")
    for arguments, code, words in (
        (["forging_chu"], 2, "did you mean 'forging_chu2020'"),
        (["five_bar", "--trajectory", file, "--bag", bag], 2, "give one of them"),
        (["five_bar", "--topic", "/joint_states"], 2, "give --bag too"),
        (["five_bar", "--port", "99999"], 2, "--port"),
        (["five_bar", "--trajectory", file], 1, "no column"),
        (
            ["five_bar", "--trajectory", bag],
            2,
            "seems to be an empty folder; expected a trajectory",
        ),
        (["five_bar", "--bag", bag], 2, "seems to be an empty folder; expected a recording"),
        (["five_bar", "--host", "nowhere.invalid"], 2, "nowhere.invalid"),
    ):
        result = call(*arguments)
        assert result.exit_code == code, result.output
        assert words in result.output
        assert "Traceback" not in result.output


def test_a_port_in_use_is_reported() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        result = call("five_bar", "--host", "127.0.0.1", "--port", str(port))
    assert result.exit_code == 2
    assert f"port {port} of 127.0.0.1 is in use" in result.output
    assert "--port" in result.output


@pytest.mark.parametrize("rates", [False, True])
def test_a_trajectory_file_is_played(forging: Robot, tmp_path: Path, rates: bool) -> None:
    time, curve = swing(forging)
    wanted = curve(time)
    file = tmp_path / "swing.npz"
    given = {"du": wanted.du} if rates else {}
    np.savez(file, time=time + 5.0, u=wanted.u, **given)
    robot, motion, losses = what_to_show(forging.name, file, None, None)
    assert (robot.active, losses, motion.title) == (forging.active, [], "swing.npz")
    assert motion.duration == pytest.approx(1.0)
    # a spline through points 10 ms apart: its error is of the order of h^4 u''''/384 < 1e-6
    assert np.abs(motion.state.u - curve(motion.time).u).max() < 1e-6
    session = ViewSession(robot, motion)
    session.show_sample(motion.index(0.3))
    exact = curve(0.3)
    needed = forging.inverse_dynamics(forging.close(exact.u, exact.du), exact.ddu)
    assert session.efforts().values == pytest.approx(
        needed, rel=1e-2, abs=1.0
    )  # cubics: accelerations to 1 %


@pytest.mark.parametrize("name", ["swing.csv", "swing.npz"])
def test_a_saved_simulation_is_played_with_the_efforts_that_made_it(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = load("excavator")
    weight = simulate(
        robot,
        robot.close(robot.reference, np.array([0.3, 0.0, 0.0, 0.0])),
        tau=lambda _time, state: robot.minimal_form(state)[2],
        t_span=(0.0, 0.5),
    )
    weight.save(tmp_path / name)
    motion = what_to_show("excavator", tmp_path / name, None, None)[1]
    assert motion is not None
    assert motion.recorded is not None
    expected = robot.inverse_dynamics(motion.state, motion.ddu)
    # quintics through exact rates and accelerations every 10 ms: what is left is the file's samples
    # brought onto the player's times, below 1e-4 of the largest effort
    assert np.abs(expected - motion.recorded).max() < 1e-4 * np.abs(motion.recorded).max()
    assert " not used: " in capsys.readouterr().err


def test_positions_alone_are_not_made_to_start_from_standstill(
    forging: Robot, tmp_path: Path
) -> None:
    time = np.linspace(0.0, 1.0, 101)[:, None]
    rise = np.array([0.1, 0.02, -0.02, 0.2])
    np.savez(
        tmp_path / "a.npz",
        time=time[:, 0],
        position=forging.reference + rise * (time + time**2 - time**3),
    )
    motion = what_to_show(forging.name, tmp_path / "a.npz", None, None)[1]
    assert motion is not None
    at = motion.time[:, None]
    # a cubic is its own spline; second differences of points 10 ms apart blow their rounding up 1e4
    # times
    assert motion.state.du == pytest.approx(rise * (1.0 + 2.0 * at - 3.0 * at**2), abs=1e-10)
    assert motion.ddu == pytest.approx(rise * (2.0 - 6.0 * at), abs=1e-8)


def test_a_recording_is_played_with_its_efforts(forging: Robot, tmp_path: Path) -> None:
    make = pytest.importorskip(
        "hybrid_dynamics_ros.bags.make", reason="rosbags, of the extra `bag`, is missing"
    )
    bag = tmp_path / "recording"
    trajectory = make.simulated(forging, 1.0, 200.0)
    make.write_trajectory(bag, trajectory, "/joint_states", {"robot": forging.name})
    robot, motion, losses = what_to_show(forging.name, None, bag, "/joint_states")
    assert losses == []
    assert motion.time[-1] == pytest.approx(trajectory.time[-1], abs=1e-6)
    assert motion.state.u == pytest.approx(trajectory.position, abs=1e-12)
    assert motion.recorded == pytest.approx(trajectory.effort, abs=1e-9)
    session = ViewSession(robot, motion)
    session.show_sample(100)
    efforts = session.efforts()
    # a spline through samples 5 ms apart, of a motion of some rad/s: to 1e-4 of the largest effort,
    # a few kN
    assert efforts.values == pytest.approx(efforts.recorded, rel=1e-4, abs=0.5)
    assert "a spline through the recording: no lag" in motion.note
    track = SimpleNamespace(is_causal=True, causal_lag=0.0204)
    note = acceleration_note(track)  # type: ignore[arg-type]  # of a bag that was processed so
    assert "20.4 ms late" in note
    track = SimpleNamespace(is_causal=True, causal_lag=0.0)
    assert "Kalman filter: no lag" in acceleration_note(track)  # type: ignore[arg-type]


@pytest.mark.parametrize("number", swept([signal.SIGINT, signal.SIGTERM], [signal.SIGINT]))
def test_a_lossy_recording_is_played_and_the_loss_reported(
    forging: Robot, tmp_path: Path, number: int
) -> None:
    make = pytest.importorskip(
        "hybrid_dynamics_ros.bags.make", reason="rosbags, of the extra `bag`, is missing"
    )
    bag = tmp_path / "recording"
    make.write_trajectory(
        bag, make.simulated(forging, 1.0, 200.0), "/joint_states", {"robot": forging.name}
    )
    metadata = (bag / "metadata.yaml").read_text(encoding="utf-8")
    (bag / "metadata.yaml").write_text(
        metadata.replace("message_count: 200", "message_count: 300"), encoding="utf-8"
    )
    arguments = [
        forging.name,
        "--bag",
        str(bag),
        "--topic",
        "/joint_states",
        "--port",
        "0",
        "--no-browser",
    ]
    process = subprocess.Popen(
        [sys.executable, "-m", "hybrid_dynamics_cli", "view", *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert "http://localhost:" in process.stdout.readline()
    process.send_signal(number)
    out, problems = process.communicate(timeout=120.0)
    assert process.returncode == LOST
    assert out.split() == ["ended"]
    assert "200 messages could be read of 300" in problems
    assert "Traceback" not in problems
