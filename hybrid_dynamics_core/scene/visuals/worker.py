"""The process that reads meshes with trimesh, isolated from files and network.

It is run by its path and imports only trimesh, NumPy and the standard library. It receives the
content of files and opens none itself. Resource limits of the system bound its time and memory.

A request is a line of JSON with sizes, followed by the content. An answer is a line of JSON,
followed by vertices and faces of every part.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import runpy
import sys
from pathlib import Path
from typing import Any
from urllib.parse import unquote

_MEMORY = 1_000_000_000  # bytes
_SAMPLES = {  # read before the limits apply, so that lazy imports of the libraries happen before
    "stl": b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    b"endloop\nendfacet\nendsolid s\n",
    "obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "gltf": b'{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],'
    b'"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,'
    b'"componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],'
    b'"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACA'
    b'PwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}',
    "dae": b'<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>'
    b'<unit meter="1"/></asset><library_geometries><geometry id="g"><mesh><source id="p">'
    b'<float_array id="a" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common><accessor'
    b' source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"'
    b'/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="v">'
    b'<input semantic="POSITION" source="#p"/></vertices><triangles count="1"><input semantic='
    b'"VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>'
    b'</library_geometries><library_visual_scenes><visual_scene id="s"><node><instance_geometry'
    b' url="#g"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene'
    b' url="#s"/></scene></COLLADA>',
}
_UNIT = re.compile(rb"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']+)[\"']")
_Part = tuple[Any, Any, list[int] | None]  # vertices, faces, colour


def parts_of(content: bytes, kind: str, files: dict[str, bytes]) -> list[_Part]:
    """The parts of a mesh in the frame of its file."""
    decoded = {unquote(name): data for name, data in files.items()}
    beside = {**decoded, **files}  # by version, trimesh uses one or the other name
    scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, resolver=beside, process=False)
    scale = 1.0
    unit = _UNIT.search(content)
    if kind == "dae" and unit is not None:
        scale = float(unit[1])
    parts: list[_Part] = []
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not isinstance(mesh, trimesh.Trimesh):
            continue
        vertices: Any = scale * (mesh.vertices @ pose[:3, :3].T + pose[:3, 3])
        faces: Any = mesh.faces
        if numpy.linalg.det(pose[:3, :3]) < 0.0:
            faces = faces[:, ::-1]
        parts.append((vertices, faces, colour_of(mesh.visual)))
    return parts


def colour_of(visual: Any) -> list[int] | None:
    """The main colour of a mesh, 0 to 255; None if it has none."""
    if not visual.defined:
        return None
    material = getattr(visual, "material", visual)
    colour = getattr(material, "main_color", None)
    if colour is None:
        return None
    return [int(number) for number in colour]


def answer(request: dict[str, Any], source: Any) -> tuple[dict[str, Any], list[bytes]]:
    """The answer to a request: a line, and arrays as bytes."""
    content = source.read(request["size"])
    files = {name: source.read(size) for name, size in request["files"].items()}
    try:
        parts = parts_of(content, request["kind"], files)
    except MemoryError:
        return {"error": f"needs more than {_MEMORY} bytes of memory"}, []
    except Exception as error:  # noqa: BLE001 - trimesh raises whatever it is that it met
        return {"error": f"{type(error).__name__}: {error}"[:300]}, []
    count = sum(len(faces) for _, faces, _ in parts)
    if count > request["triangles"]:
        return {"error": f"{count} triangles; a robot has at most {request['most']}"}, []
    lines: list[dict[str, Any]] = []
    arrays: list[bytes] = []
    for vertices, faces, colour in parts:
        lines.append({"vertices": len(vertices), "faces": len(faces), "colour": colour})
        arrays.append(numpy.ascontiguousarray(vertices, "<f8").tobytes())
        arrays.append(numpy.ascontiguousarray(faces, "<i8").tobytes())
    return {"parts": lines}, arrays


def serve(source: Any, target: Any) -> None:
    """Answer requests until the input ends."""
    while True:
        line = source.readline()
        if not line:
            return
        request = json.loads(line)
        limits["limit_computing"](request["seconds"])
        reply, arrays = answer(request, source)
        target.write(json.dumps(reply).encode() + b"\n")
        for array in arrays:
            target.write(array)
        target.flush()


limits = runpy.run_path(str(Path(__file__).parents[2] / "ground" / "worker_limits.py"))
start = json.loads(sys.stdin.buffer.readline())
sys.path[:] = start["path"]
import numpy  # noqa: E402 - found by the parent's path
import trimesh  # type: ignore[import-untyped,unused-ignore]  # noqa: E402

answers = os.fdopen(os.dup(1), "wb")
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # discards what libraries print
for sample_kind, sample in _SAMPLES.items():
    with contextlib.suppress(Exception):  # a missing library is reported by its request
        parts_of(sample, sample_kind, {})
limits["close_off"](_MEMORY)
serve(sys.stdin.buffer, answers)
os._exit(0)
