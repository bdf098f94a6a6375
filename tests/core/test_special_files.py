"""What is no regular file is refused at once, whoever would have to answer first."""

import os
import socket
import time
from pathlib import Path

import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_core.errors import DescriptionError
from hybrid_dynamics_core.ground import file_kinds, regular_files
from hybrid_dynamics_core.ground.regular_files import answered_in_time, open_regular, read_regular


@pytest.fixture
def place(tmp_path):
    """Makes a special file of a kind, under a name."""
    sockets = []

    def make(kind, name):
        path = tmp_path / name
        if kind == "a pipe":
            os.mkfifo(path)
        elif kind == "a socket":
            sockets.append(socket.socket(socket.AF_UNIX))
            sockets[-1].bind(str(path))
        else:
            path.symlink_to("/dev/zero")
        return path

    yield make
    for each in sockets:
        each.close()


@pytest.mark.parametrize("kind", ["a pipe", "a socket", "a device"])
def test_a_special_file_is_no_robot(place, kind):
    with pytest.raises(DescriptionError, match=f"seems to be {kind}; expected a robot description"):
        load(place(kind, "robot.yaml"))
    with pytest.raises(OSError, match=f"it is {kind}; expected a regular file"):
        read_regular(place(kind, "data"), 10)


@pytest.mark.parametrize("kind", ["a pipe", "a socket", "a device"])
def test_a_special_file_is_no_recording(place, kind):
    pytest.importorskip("rosbags")
    from hybrid_dynamics_ros.bags.settings import read_settings
    from hybrid_dynamics_ros.bags.storage.bag_reader import BagReader

    with pytest.raises(Exception, match=f"seems to be {kind}"):
        BagReader(place(kind, "recording.mcap"))
    with pytest.raises(Exception, match=f"seems to be {kind}"):
        read_settings(place(kind, "node.yaml"))


def test_a_urdf_that_is_a_pipe_is_refused_where_a_robot_file_names_it(place, tmp_path):
    place("a pipe", "arm.urdf")
    text = "format: 1\nname: arm\nurdf: arm.urdf\nactive: [a]\nend_effector: {link: b}\n"
    (tmp_path / "robot.yaml").write_text(text)
    with pytest.raises(DescriptionError, match=r"there is no file .*arm.urdf"):
        load(tmp_path / "robot.yaml")


def test_a_recording_whose_file_is_a_pipe_has_no_file(place, tmp_path):
    pytest.importorskip("rosbags")
    from hybrid_dynamics_ros.bags.storage.bag_reader import BagReader

    place("a pipe", "part.mcap")
    with pytest.raises(Exception, match=r"no .mcap or .db3 file is left|seems to be"):
        BagReader(tmp_path)


def test_a_path_that_becomes_a_pipe_in_between_is_refused(place, tmp_path, monkeypatch):
    """Between the question what it is and its opening."""
    pipe = place("a pipe", "pipe")
    (tmp_path / "file").write_text("format: 1\n")
    status = (tmp_path / "file").stat()
    monkeypatch.setattr(Path, "stat", lambda *_, **__: status)
    with pytest.raises(OSError, match="it is a pipe"):
        open_regular(pipe)


@pytest.mark.parametrize("call", ["stat", "exists"])
def test_a_file_system_that_never_answers_is_told(tmp_path, monkeypatch, call):
    """As a network mount whose server is gone: the question waits, and nothing ends it."""
    path = tmp_path / "robot.yaml"
    answer = getattr(Path, call)

    def waits(self, *args, **options):
        if self == path:
            time.sleep(20.0)
        return answer(self, *args, **options)

    def soon(ask):
        return answered_in_time(ask, 0.05)

    monkeypatch.setattr(Path, call, waits)
    for module in (file_kinds, regular_files):
        monkeypatch.setattr(module, "answered_in_time", soon)
    monkeypatch.setattr("hybrid_dynamics_core.library.answered_in_time", soon)
    with pytest.raises(DescriptionError, match=r"no answer within 0.05 s; is its file system"):
        load(path)


def test_what_a_question_raises_comes_back():
    with pytest.raises(ZeroDivisionError):
        answered_in_time(lambda: 1 // 0)
    assert answered_in_time(lambda: 3) == 3


def test_a_file_is_read_up_to_its_limit(tmp_path):
    (tmp_path / "file").write_bytes(b"0123456789")
    assert read_regular(tmp_path / "file", 4) == b"0123"
    assert read_regular(tmp_path / "file", 40) == b"0123456789"
