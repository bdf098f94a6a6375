"""Meshes of every format; those of strangers are refused with the limit that they break."""

from __future__ import annotations

import base64
import json
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest

from hybrid_dynamics_core.scene.visuals import meshes
from hybrid_dynamics_core.scene.visuals.meshes import MeshError, Result, read_meshes
from tests.mesh_files import CORNERS, FACES, write_mesh

pytest.importorskip("trimesh")


def result_of(file: Path) -> Result:
    return read_meshes([file])[file]


def test_every_format_gives_the_same_triangles(tmp_path: Path) -> None:
    """A DAE is in its unit, here millimetres."""
    suffixes = ("stl", "obj", "gltf", "glb", "dae")
    files = [write_mesh(tmp_path / f"m.{suffix}") for suffix in suffixes]
    for file, parts in read_meshes(files).items():
        if file.suffix == ".dae" and find_spec("collada") is None:
            assert "pip install pycollada" in str(parts)
            continue
        assert not isinstance(parts, MeshError), f"{file.name}: {parts}"
        (part,) = parts
        scale = 0.001 if file.suffix == ".dae" else 1.0
        assert part.vertices[part.faces] == pytest.approx(scale * CORNERS[FACES], rel=1e-6)
        assert part.colour is None
        assert not part.vertices.flags.writeable


def test_colours_and_places_in_a_gltf(tmp_path: Path) -> None:
    file = write_mesh(tmp_path / "m.gltf")
    content = json.loads(file.read_text())
    content["nodes"][0]["translation"] = [1, 2, 3]
    content["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]
    content["meshes"][0]["primitives"][0]["material"] = 0
    buffer = content["buffers"][0]
    (tmp_path / "b in.bin").write_bytes(_decoded(buffer["uri"]))
    buffer["uri"] = "b%20in.bin"
    file.write_text(json.dumps(content))
    (part,) = result_of(file)
    assert part.vertices.min(axis=0) == pytest.approx([1, 2, 3])
    assert part.colour == (1, 0, 0, 1)


def _decoded(uri: str) -> bytes:
    return base64.b64decode(uri.partition(",")[2])


def changed(change: Callable[[dict], None]) -> Callable[[Path], Path]:
    """A glTF with something else in it."""

    def write(folder: Path) -> Path:
        file = write_mesh(folder / "m.gltf")
        content = json.loads(file.read_text())
        change(content)
        file.write_text(json.dumps(content))
        return file

    return write


def with_bytes(name: str, data: bytes) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    return write


def huge(content: dict) -> None:
    """An accessor of zeros that takes no place in the file."""
    del content["accessors"][0]["bufferView"]
    content["accessors"][0]["count"] = 10**10


def outside(content: dict) -> None:
    content["buffers"][0]["uri"] = "../../etc/passwd"


def fetched(content: dict) -> None:
    content["buffers"][0]["uri"] = "http://localhost/b.bin"


def beyond(content: dict) -> None:
    """Triangles of vertices that are not there."""
    content["accessors"][0]["count"] = 2


DAE = b"<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b 'c'>]><COLLADA>&b;</COLLADA>"
HOSTILE = {
    "garbage stl": (with_bytes("m.stl", b"nothing"), "it has no triangles"),
    "garbage obj": (with_bytes("m.obj", b"\x00\xff" * 99), ""),
    "garbage gltf": (with_bytes("m.gltf", b"{"), "no glTF"),
    "deep gltf": (with_bytes("m.gltf", b"[" * 100_000), "no glTF"),
    "garbage glb": (with_bytes("m.glb", b"glTF" + b"\xff" * 99), "not read: "),
    "archive": (with_bytes("m.stl", b"PK\x03\x04" + bytes(99)), "an archive, which is not opened"),
    "entities": (with_bytes("m.dae", DAE), "a document type, which could define entities"),
    "huge": (changed(huge), ""),
    "outside": (changed(outside), "'../../etc/passwd' is not below its folder"),
    "fetched": (changed(fetched), "'http://localhost/b.bin' is not below its folder"),
    "beyond": (changed(beyond), ""),
    "not finite": (with_bytes("m.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3"), "not finite"),
    "counted wrong": (with_bytes("m.stl", bytes(80) + b"\xff" * 200), ""),
}


def test_meshes_of_strangers_are_refused_and_others_are_read(tmp_path: Path) -> None:
    files: dict[str, Path] = {}
    for case, (write, _) in HOSTILE.items():
        folder = tmp_path / case
        folder.mkdir()
        files[case] = write(folder)
    good = write_mesh(tmp_path / "good.stl")
    results = read_meshes([*files.values(), good])
    for case, (_, words) in HOSTILE.items():
        result = results[files[case]]
        assert isinstance(result, MeshError), case
        assert words in str(result), case
    assert not isinstance(results[good], MeshError)


def test_a_robot_has_a_bounded_number_of_triangles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(meshes, "MAX_TRIANGLES", 6)
    one, other = write_mesh(tmp_path / "1.stl"), write_mesh(tmp_path / "2.stl")
    results = read_meshes([one, other])
    assert not isinstance(results[one], MeshError)
    assert str(results[other]) == "not read: 4 triangles; a robot has at most 6"


def test_a_robot_has_a_bounded_number_of_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = write_mesh(tmp_path / "1.stl"), write_mesh(tmp_path / "2.stl")
    monkeypatch.setattr(meshes, "MAX_SUM", one.stat().st_size)
    results = read_meshes([one, other])
    assert not isinstance(results[one], MeshError)
    assert "the meshes have more than" in str(results[other])


@pytest.mark.sweep(sample="test_meshes_of_strangers_are_refused_and_others_are_read")
def test_a_mesh_that_takes_too_long_is_ended_and_others_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(meshes, "MAX_SECONDS", 1)
    bad = tmp_path / "bad.obj"
    bad.write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"f 1 2 3\n" * 5_000_000)
    good = write_mesh(tmp_path / "good.stl")
    results = read_meshes([bad, good])
    assert str(results[bad]) == "takes more than 1 s of computing"
    assert not isinstance(results[good], MeshError)


def test_a_mesh_is_read_once_until_it_is_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = write_mesh(tmp_path / "m.stl")
    first = result_of(file)
    with monkeypatch.context() as patch:
        patch.setattr(meshes, "_content", None)
        assert result_of(file) is first
    write_mesh(file, 2.0 * CORNERS, FACES[:3])
    (part,) = result_of(file)
    assert part.vertices.max() == 6.0


def test_without_trimesh_the_reason_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(meshes, "find_spec", lambda _: None)
    assert str(result_of(write_mesh(tmp_path / "m.stl"))).endswith("pip install trimesh pycollada")


def test_without_pycollada_a_dae_says_what_to_install_and_others_are_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    collada = pytest.importorskip("collada")
    installed = Path(collada.__file__).parent.parent
    packages = tmp_path / "packages"
    packages.mkdir()
    for entry in installed.iterdir():
        if "collada" not in entry.name:
            (packages / entry.name).symlink_to(entry)
    paths = [str(packages) if Path(path) == installed else path for path in sys.path]
    monkeypatch.setattr(sys, "path", paths)
    dae, stl = (write_mesh(tmp_path / f"m.{suffix}") for suffix in ("dae", "stl"))
    results = read_meshes([dae, stl])
    assert "pip install pycollada" in str(results[dae])
    assert not isinstance(results[stl], MeshError)
