"""Small meshes, written where a test needs them."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path

import numpy as np

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], float)  # a tetrahedron
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def write_mesh(file: Path, corners: np.ndarray = CORNERS, faces: np.ndarray = FACES) -> Path:
    """A mesh in the format of the suffix of its file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    writers = {".stl": _stl, ".obj": _obj, ".gltf": _gltf, ".glb": _glb, ".dae": _dae}
    file.write_bytes(writers[file.suffix](corners, faces))
    return file


def _stl(corners: np.ndarray, faces: np.ndarray) -> bytes:
    data = bytes(80) + struct.pack("<I", len(faces))
    for face in faces:
        data += struct.pack("<12fH", 0, 0, 0, *corners[face].ravel(), 0)
    return data


def _obj(corners: np.ndarray, faces: np.ndarray) -> bytes:
    lines = ["v {} {} {}".format(*corner) for corner in corners]
    lines += ["f {} {} {}".format(*(face + 1)) for face in faces]
    return "\n".join(lines).encode()


def _gltf(corners: np.ndarray, faces: np.ndarray) -> bytes:
    content, buffer = _gltf_content(corners, faces)
    uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    content["buffers"][0]["uri"] = uri
    return json.dumps(content).encode()


def _glb(corners: np.ndarray, faces: np.ndarray) -> bytes:
    content, buffer = _gltf_content(corners, faces)
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(buffer), 0x004E4942) + buffer
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def _gltf_content(corners: np.ndarray, faces: np.ndarray) -> tuple[dict, bytes]:
    places = corners.astype("<f4").tobytes()
    indices = faces.astype("<u4").tobytes()
    view = {"buffer": 0, "byteOffset": 0, "byteLength": len(places)}
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": len(corners),
                "type": "VEC3",
                "min": corners.min(axis=0).tolist(),
                "max": corners.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            view,
            {"buffer": 0, "byteOffset": len(places), "byteLength": len(indices)},
        ],
        "buffers": [{"byteLength": len(places) + len(indices)}],
    }
    return content, places + indices


def _dae(corners: np.ndarray, faces: np.ndarray) -> bytes:
    numbers = " ".join(map(repr, corners.ravel().tolist()))
    indices = " ".join(map(str, faces.ravel()))
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="{corners.size}">{numbers}</float_array>
<technique_common><accessor source="#a" count="{len(corners)}" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(faces)}"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{indices}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()
