"""Shapes (geoms) in the process that compiles MJCF, with their poses on bodies.

The worker loads this file by its path. It imports only MuJoCo and NumPy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

_GREY = (0.5, 0.5, 0.5, 1.0)  # default colour of MuJoCo
_GEOM = mujoco.mjtGeom
_KINDS = {
    _GEOM.mjGEOM_SPHERE: "sphere",
    _GEOM.mjGEOM_CAPSULE: "capsule",
    _GEOM.mjGEOM_ELLIPSOID: "ellipsoid",
    _GEOM.mjGEOM_CYLINDER: "cylinder",
    _GEOM.mjGEOM_BOX: "box",
    _GEOM.mjGEOM_MESH: "mesh",
}


@dataclass(frozen=True)
class _Shown:
    """Shape with its kind, the names of its mesh and material, and whether it has contacts."""

    geom: Any
    kind: str
    mesh: str
    material: str
    touches: bool


class Geoms:
    """Shapes of a model. Meshes are recorded before they are removed.

    Attributes:
        shown: all shapes.
        meshes: meshes by name.
        materials: colours by name.
    """

    def __init__(self, spec: Any) -> None:
        self.shown: list[_Shown] = []
        self.meshes: dict[str, dict[str, Any]] = {}
        for mesh in spec.meshes:
            self.meshes[mesh.name] = {
                "file": mesh.file,
                "scale": mesh.scale.tolist(),
                "refpos": mesh.refpos.tolist(),
                "refquat": mesh.refquat.tolist(),
            }
        self.hidden: dict[int, int] = {}  # by index of the body: number of hidden shapes
        self.materials = {material.name: material.rgba for material in spec.materials}

    def add(self, geom: Any) -> None:
        """Record a shape, and remove its material."""
        kind = _KINDS.get(geom.type, "")
        if geom.meshname and kind != "mesh":
            kind = ""  # the size would be that of the mesh
        touches = bool(geom.contype or geom.conaffinity)
        self.shown.append(_Shown(geom, kind, geom.meshname, geom.material, touches))
        geom.material = ""

    def hide(self, geom: Any, body: int) -> None:
        """Replace a mesh by a small massless ball, whose pose MuJoCo still computes."""
        geom.type = _GEOM.mjGEOM_SPHERE
        geom.meshname = ""
        geom.hfieldname = ""
        geom.size = [1e-3, 0.0, 0.0]
        geom.fromto = np.full(6, np.nan)
        geom.mass = 0.0
        self.hidden[body] = self.hidden.get(body, 0) + 1

    def weigh(self, body: Any) -> bool:
        """Whether a body has shapes that may contribute mass."""
        return len(body.geoms) > self.hidden.get(body.id, 0)

    def content(self, model: Any) -> list[dict[str, Any]]:
        """All shapes as plain data."""
        return [self._content(model, shown) for shown in self.shown]

    def _content(self, model: Any, shown: _Shown) -> dict[str, Any]:
        geom = shown.geom
        k = geom.id
        pos, quat = _without_mesh_pose(model, k)
        return {
            "line": geom.info,
            "body": int(model.geom_bodyid[k]),
            "name": geom.name,
            "kind": shown.kind,
            "mesh": self.meshes.get(shown.mesh) if shown.kind == "mesh" else None,
            "size": model.geom_size[k].tolist(),
            "pos": pos.tolist(),
            "quat": quat.tolist(),
            "colour": self._colour(geom, shown.material),
            "group": int(geom.group),
            "touches": shown.touches,
        }

    def _colour(self, geom: Any, material: str) -> list[float]:
        """The colour of a shape: its own, or that of its material; empty if it has none."""
        rgba = geom.rgba
        if tuple(rgba.tolist()) == _GREY:
            rgba = self.materials.get(material, [])
        return [float(str(np.float32(number))) for number in rgba]


def _without_mesh_pose(model: Any, k: int) -> tuple[Any, Any]:
    """The pose of a shape as in the file, although MuJoCo moves a mesh to its centre of mass."""
    pos, quat = model.geom_pos[k], model.geom_quat[k]
    mesh = model.geom_dataid[k]
    if model.geom_type[k] != _GEOM.mjGEOM_MESH or mesh < 0:
        return pos, quat
    back, written, shift = np.zeros(4), np.zeros(4), np.zeros(3)
    mujoco.mju_negQuat(back, model.mesh_quat[mesh])
    mujoco.mju_mulQuat(written, quat, back)
    mujoco.mju_rotVecQuat(shift, model.mesh_pos[mesh], written)
    return pos - shift, written
