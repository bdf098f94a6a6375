"""Code from the cache is used when it is complete and meant for exactly this, else made anew."""

from __future__ import annotations

import os
import pickle
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import load, programs
from hybrid_dynamics_core.kernels import artifact, cache, digest, native, run
from hybrid_dynamics_core.kernels.cache import Entry
from hybrid_dynamics_core.kernels.run import Kernel
from tests.kernels.programs_of import BACKENDS
from tests.mechanisms import changed
from tests.sampling import swept

U = np.array([0.3, 0.15, 0.175, 0.4])
ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache of its own."""
    place = tmp_path / "kept"
    monkeypatch.setenv(cache.VARIABLE, str(place))
    return place


def inverse_kernel(backend: str) -> Kernel:
    robot = load("forging_chu2020")
    pattern, _ = robot._dynamics.pack(robot.loads)
    made = robot.kernel("inverse_dynamics", programs.inverse_dynamics(pattern))
    return Kernel(made._program, made._sizes, backend)


def tau(kernel: Kernel) -> np.ndarray:
    zero = np.zeros(4)
    robot = load("forging_chu2020")
    values, status = kernel(
        U, zero, zero, robot._closure.signs, robot._closure.start, np.array([0.0, 0.0, -9.81])
    )
    assert status == 0
    return values["tau"]


def entries(folder: Path) -> list[Path]:
    """Files of kernels; those that hold digests of code are none of them."""
    paths = sorted(folder.glob("*.kernel"))
    return [path for path in paths if b'"bytecode"' not in path.read_bytes()]


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_second_start_needs_no_tracing(
    folder: Path, backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = inverse_kernel(backend)
    expected = tau(first)
    assert entries(folder)

    def refuse(*_: object) -> None:
        raise AssertionError("traced")

    monkeypatch.setattr(run, "trace", refuse)
    second = inverse_kernel(backend)
    assert np.array_equal(tau(second), expected)
    assert second.layout == first.layout


DAMAGES = ("short", "one bit of the code", "one bit of the facts", "empty", "noise", "longer")


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("damage", swept(DAMAGES, DAMAGES[:3]))
def test_a_damaged_entry_is_made_anew(
    folder: Path, backend: str, damage: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(native, "LEVEL", 0)  # compiled in a fifth of the time
    expected = tau(inverse_kernel(backend))
    for path in entries(folder):
        data = bytearray(path.read_bytes())
        if damage == "one bit of the code":
            data[-40] ^= 4
        elif damage == "one bit of the facts":
            data[90] ^= 1
        new = {
            "empty": b"",
            "short": bytes(data[: len(data) // 2]),
            "noise": os.urandom(500),
            "longer": bytes(data) + b"x",
        }
        path.write_bytes(new.get(damage, bytes(data)))
    damaged = [path.read_bytes() for path in entries(folder)]
    assert np.array_equal(tau(inverse_kernel(backend)), expected)
    assert all(path.read_bytes() not in damaged for path in entries(folder))


def test_an_entry_under_another_name_is_not_used(folder: Path) -> None:
    cache.write("a" * 64, Entry({"layout": []}, b"code"))
    (folder / ("a" * 64 + ".kernel")).rename(folder / ("b" * 64 + ".kernel"))
    assert cache.read("a" * 64) is None
    assert cache.read("b" * 64) is None


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.usefixtures("folder")
def test_everything_that_code_depends_on_is_in_its_key(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = inverse_kernel(backend)

    def key(form: str = "one", sizes: tuple[int, ...] = made._sizes) -> str:
        return Kernel(made._program, sizes, backend)._key(form)  # type: ignore[arg-type]

    keys = [key(), key("rows"), key(sizes=(1,))]
    assert key() == keys[0]
    with monkeypatch.context() as patch:
        patch.setattr(artifact, "formula_digest", lambda: "another version of this package")
        keys.append(key())
    with monkeypatch.context() as patch:
        patch.setattr(np, "__version__", "1.0")
        keys.append(key())
    with monkeypatch.context() as patch:
        patch.setattr(native.platform, "python_version", lambda: "3.99.0")
        keys.append(key())
    if backend == "native":
        with monkeypatch.context() as patch:
            patch.setattr(native.llvm, "processor", lambda: ("another processor", ""))
            keys.append(key())
    assert len(set(keys)) == len(keys)


def test_another_number_in_the_description_is_another_entry() -> None:
    robot = load("forging_chu2020")
    links = dict(robot.description.links)
    from dataclasses import replace

    links["l2"] = replace(links["l2"], mass=links["l2"].mass * (1.0 + 1e-15))
    heavier = changed(robot, links=links)
    assert digest.digest(robot._model.program_model) == digest.digest(
        load("forging_chu2020")._model.program_model
    )
    assert digest.digest(robot._model.program_model) != digest.digest(heavier._model.program_model)


def test_digest_tells_types_orders_and_places_apart() -> None:
    shared = [1.0]
    things = [
        None, True, 1, 1.0, -0.0, 0.0, "1", b"1", (), [], {}, set(), (1, 2), (2, 1), [1, 2],
        ((1,), 2), ("ab", "c"), ("a", "bc"), {"a": 1}, {"a": 1.0}, {1: 2, 3: 4}, {3: 4, 1: 2},
        frozenset({1, 2}), frozenset({1, 3}), np.zeros(2), np.zeros((2, 1)),
        np.zeros(2, dtype=np.float32), np.array([0.0, -0.0]), int, float,
        [shared, shared], [[1.0], [2.0]],
    ]  # fmt: skip
    assert len({digest.digest(thing) for thing in things}) == len(things)
    assert digest.digest(frozenset({"x", "y", "z"})) == digest.digest(frozenset({"z", "y", "x"}))
    endless: list[object] = []
    endless.append(endless)
    assert digest.digest(endless)


def test_what_has_no_digest_is_not_kept(folder: Path) -> None:
    scale = np.float64(2.0)
    kernel = Kernel(
        lambda x: run.trace and _doubled(x, scale), [1]
    )  # a function of this test, not of the package
    values, _ = kernel(np.array([3.0]))
    assert values["y"] == 6.0
    assert not entries(folder)
    with pytest.raises(digest.NoDigestError):
        digest.digest(lambda: None)


def _doubled(x: list, scale: float) -> object:
    from hybrid_dynamics_core.kernels.trace import Results

    return Results({"y": x[0] * float(scale)}, [])


@pytest.mark.parametrize("told", ["off", "0", "", "no"])
def test_it_can_be_switched_off(told: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv(cache.VARIABLE, told)
    assert tau(inverse_kernel(BACKENDS[-1])).shape == (4,)
    assert not list(tmp_path.iterdir())


def test_the_place_follows_the_platform(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(cache.VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(cache.platform, "system", lambda: "Linux")
    assert cache.folder() == tmp_path / "hybrid_dynamics"
    assert stat.S_IMODE((tmp_path / "hybrid_dynamics").stat().st_mode) == 0o700
    monkeypatch.setattr(Path, "home", lambda: tmp_path / "me")
    monkeypatch.setattr(cache.platform, "system", lambda: "Darwin")
    assert cache.folder() == tmp_path / "me" / "Library" / "Caches" / "hybrid_dynamics"
    monkeypatch.setattr(cache.platform, "system", lambda: "Windows")
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    assert cache.folder() == tmp_path / "local" / "hybrid_dynamics"


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no owners here")
def test_a_folder_that_others_can_write_is_not_used(folder: Path) -> None:
    folder.mkdir()
    folder.chmod(0o777)
    assert cache.folder() is None
    assert tau(inverse_kernel(BACKENDS[-1])).shape == (4,)
    assert not entries(folder)


def test_a_place_that_is_no_folder_is_no_error(folder: Path) -> None:
    folder.write_text("a file")
    assert cache.folder() is None
    assert tau(inverse_kernel(BACKENDS[-1])).shape == (4,)


def test_the_oldest_go_when_there_are_many(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tenth at a time: most entries that are written cost no look at the others."""
    monkeypatch.setattr(cache, "MAX_ENTRIES", 4)
    for k in range(5):
        cache.write(str(k) * 64, Entry())
        os.utime(folder / (str(k) * 64 + ".kernel"), (k, k))
    assert [path.name[0] for path in entries(folder)] == ["2", "3", "4"]


ONE_PROCESS = """
import numpy as np
from hybrid_dynamics_core import load
k = load("forging_chu2020").kernels
u = np.array([0.3, 0.15, 0.175, 0.4])
print(k.inverse_dynamics(u, u, u).tobytes().hex())
print(k.inverse_dynamics(np.tile(u, (9, 1)), u, u)[8].tobytes().hex())
"""


@pytest.mark.sweep(sample="test_a_second_start_needs_no_tracing")
def test_many_processes_may_start_at_once(folder: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", ONE_PROCESS]
    started = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE) for _ in range(4)]
    answers = {process.communicate()[0] for process in started}
    assert all(process.returncode == 0 for process in started)
    assert len(answers) == 1
    assert len(entries(folder)) == 4  # for one state and for rows: facts, and code
    assert not list(folder.glob(".*"))
    assert (
        subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout
        in answers
    )


def test_processes_share_a_folder_where_none_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(cache.VARIABLE, "off")
    with cache.at_least_meanwhile():
        place = cache.folder()
        assert place is not None
        cache.write("key", Entry(code=b"code"))
        assert cache.read("key") == Entry(code=b"code")
    assert not place.exists()
    assert cache.folder() is None


def test_a_folder_that_is_kept_stays(folder: Path) -> None:
    with cache.at_least_meanwhile():
        assert cache.folder() == folder
    assert folder.exists()


@pytest.mark.parametrize("backend", BACKENDS)
def test_code_is_taken_from_disk_alone_where_that_is_asked_for(
    backend: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cold = inverse_kernel(backend)
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))  # it is on disk elsewhere by now
    with run.stored_only(), pytest.raises(run.NotStoredError, match="a program"):
        tau(cold)
    wanted, warm = tau(cold), inverse_kernel(backend)
    with run.stored_only():
        np.testing.assert_array_equal(tau(warm), wanted)


def test_arrays_of_another_process_run_on_the_code_for_one_state(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Pickle gives arrays a type object of their own, which compiled code does not know."""
    robot = load("forging_chu2020")
    state = robot.close(U)
    taken = pickle.loads(pickle.dumps(U))  # noqa: S301  our own
    assert taken.dtype is not U.dtype
    monkeypatch.setattr(Kernel, "fill_rows", None)
    copied = pickle.loads(pickle.dumps(state))  # noqa: S301  our own
    assert copied.s.dtype is state.s.dtype
    np.testing.assert_array_equal(robot.close(taken, near=copied).s, state.s)


def test_the_folder_is_listed_once_in_a_hundred_entries(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = []
    monkeypatch.setattr(cache, "_prune", listed.append)
    for k in range(200):
        cache.write(f"{k:064d}", Entry())
    assert listed == [folder, folder]
