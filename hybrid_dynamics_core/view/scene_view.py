"""The scene in the browser: meshes are sent once, then only poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import viser

from ..algebra.rotations import quaternion
from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..scene.skeleton import PlacedJoint, Pose, Skeleton
from ..scene.style import PURPLE, QUIET, RED
from . import meshes
from .bodies import Shape, Span, span_pose
from .camera import Camera, camera_for, floor_under
from .session import Efforts

LONGEST: Final = 0.2  # of the size of the robot: the arrow of a force that fills its bar
RING: Final = 0.065  # of the radius of an arrow round an axis: how thick it is
FAINT: Final = 0.02  # share of a bar below which there is no arrow
ON_AXIS: Final = 1e-9  # [m] nearer than this to an axis is rounding


@dataclass(frozen=True, eq=False)
class Arrow:
    """An arrow of effort: where it is and its positive direction (3,) in the axes of its link.

    opening: (3,) where a ring is open, across the axis; of no length where that is all the same;
    None: no ring.
    """

    handle: viser.MeshHandle
    base: Array
    axis: Array
    opening: Array | None

    def frame(self, sign: float) -> Array:
        """Its axes (3, 3) for an effort that is positive or negative."""
        along = np.copysign(1.0, sign) * self.axis
        if self.opening is None or not self.opening.any():
            return meshes.frame_along(along)
        return meshes.frame_open(along, self.opening)


class Stage:
    """What a viser server shows of one robot.

    `show` puts it into a state, `show_efforts` draws its arrows.
    """

    def __init__(self, server: viser.ViserServer, shape: Shape) -> None:
        self.server, self.shape, self.scene = server, shape, server.scene
        self.links = {
            name: self.scene.add_frame(node("links", name), show_axes=False)
            for name in shape.skeleton.links
        }
        self._add_bodies()
        self.spans = [(span, self._add_span(k, span)) for k, span in enumerate(shape.spans)]
        self._add_names()
        self._add_surroundings()
        self.arrows = {name: self._add_arrow(name) for name in shape.robot.drives}

    def show(self, state: ClosedState) -> None:
        """Put every link where it is."""
        poses = self.shape.poses(state)
        with self.server.atomic():
            for name, handle in self.links.items():
                rotation, origin = poses[name]
                handle.position = origin
                handle.wxyz = wxyz(rotation)
            for span, tube in self.spans:
                self._stretch(tube, span, poses)

    def show_efforts(self, efforts: Efforts) -> None:
        """Arrows as long as the bars are; along the force, or round the axis of the torque."""
        shares = dict(zip(efforts.joints, efforts.shares, strict=True))
        with self.server.atomic():
            for name, arrow in self.arrows.items():
                share = shares.get(name, 0.0)
                arrow.handle.visible = abs(share) > FAINT
                if arrow.handle.visible:
                    arrow.handle.position = arrow.base
                    arrow.handle.wxyz = wxyz(arrow.frame(share))
                    self._size(arrow, min(abs(share), 1.0))

    def _size(self, arrow: Arrow, share: float) -> None:
        handle = arrow.handle
        if arrow.opening is not None:
            handle.scale = float((2.2 + 3.4 * share) * self.shape.unit)
        else:
            length = share * LONGEST * self.shape.size
            width = self.shape.size * min(1.0, 0.35 + 0.65 * share)
            handle.scale = (width, width, length)

    def _add_bodies(self) -> None:
        for k, body in enumerate(self.shape.bodies):
            self.scene.add_mesh_simple(
                node("links", body.link, f"{k} {body.kind} {'+'.join(body.names)} {body.role}"),
                body.mesh.vertices,
                body.mesh.faces,
                color=rgb(body.colour),
            )

    def _add_span(self, k: int, span: Span) -> viser.MeshHandle:
        tube = meshes.tube(span.radius)
        name = node("spans", f"{k} {span.kind} {'+'.join(span.names)}")
        return self.scene.add_mesh_simple(name, tube.vertices, tube.faces, color=rgb(span.colour))

    def _stretch(self, handle: viser.MeshHandle, span: Span, poses: Mapping[str, Pose]) -> None:
        rotation, start, length = span_pose(span, poses)
        handle.position, handle.wxyz = start, wxyz(rotation)
        handle.scale = (1.0, 1.0, max(length, 1e-6))

    def _add_names(self) -> None:
        description, unit = self.shape.robot.description, self.shape.unit
        for name in self.shape.robot.active:
            anchor = self.shape.anchors[name]
            path = node("links", anchor.link, f"name {name}")
            self.scene.add_label(
                path, name, position=anchor.point, anchor="bottom-left", font_screen_scale=1.1
            )
        tip = self.shape.skeleton.tip
        frame = description.frames.get(tip.name)
        local = (np.eye(3), np.zeros(3)) if frame is None else (frame.rotation, frame.translation)
        self.tip = self.scene.add_frame(
            node("links", tip.link, f"frame {tip.name}"),
            axes_length=7.0 * unit,
            axes_radius=0.35 * unit,
            origin_radius=0.7 * unit,
            origin_color=rgb(PURPLE),
            wxyz=wxyz(local[0]),
            position=local[1],
        )

    def _add_surroundings(self) -> None:
        shape = self.shape
        floor, camera = (
            floor_under(shape.points, shape.unit),
            camera_for(shape.skeleton, shape.points),
        )
        self.floor, self.camera = floor, camera
        middle = (float(camera.look_at[0]), float(camera.look_at[1]), floor.level)
        self._tiles = self.scene.add_grid(
            "/floor",
            floor.side,
            floor.side,
            cell_size=floor.tile,
            section_size=5.0 * floor.tile,
            cell_color=(222, 227, 232),
            section_color=(200, 207, 214),
            plane_color=(250, 251, 252),
            plane_opacity=0.6,
            shadow_opacity=0.25,
            fade_distance=3.0 * floor.side,
            position=middle,
        )
        self._gravity: viser.MeshHandle | None = None
        gravity = np.asarray(shape.robot.description.gravity, dtype=float)
        strength = float(np.linalg.norm(gravity))
        if strength > 0.0:
            self._add_gravity(gravity / strength, strength)
        start = self.server.initial_camera
        start.position, start.look_at = camera.position, camera.look_at
        start.up, start.fov = np.array([0.0, 0.0, 1.0]), camera.field
        start.near, start.far = 0.005 * shape.size, 100.0 * shape.size

    def surround(self, points: Array, camera: Camera) -> None:
        """Floor under points (k, 3), never above where it was at the start; gravity beside what a new camera shows."""
        level = min(self.floor.level, floor_under(points, self.shape.unit).level)
        x, y, _ = self._tiles.position
        self._tiles.position = np.array([x, y, level])
        if camera is not self.camera:
            self.camera = camera
            self.server.initial_camera.position, self.server.initial_camera.look_at = (
                camera.position,
                camera.look_at,
            )
            if self._gravity is not None:
                self._gravity.position = camera.corner

    def _add_gravity(self, direction: Array, strength: float) -> None:
        mesh = meshes.arrow(0.045)
        self._gravity = self.scene.add_mesh_simple(
            "/gravity",
            mesh.vertices,
            mesh.faces,
            color=rgb(QUIET),
            cast_shadow=False,
            scale=0.14 * self.shape.size,
            wxyz=wxyz(meshes.frame_along(direction)),
            position=self.camera.corner,
        )
        self.scene.add_label("/gravity/name", f"g  {strength:.4g} m/s²", anchor="bottom-center")

    def _add_arrow(self, name: str) -> Arrow:
        """An arrow of effort, at first unseen."""
        joint = next(joint for joint in self.shape.skeleton.joints if joint.name == name)
        toward = self.camera.position - self.camera.look_at
        return (
            self._add_ring(joint, toward)
            if joint.type == "revolute"
            else self._add_shaft(joint, toward)
        )

    def _add_ring(self, joint: PlacedJoint, toward: Array) -> Arrow:
        """Round the axis, before the joint; it is open where the link is that the joint turns, and turns with it."""
        rotation, origin = self.shape.poses(self.shape.home)[joint.child]
        front = np.copysign(1.0, joint.axis @ toward) * joint.axis
        base = rotation.T @ (joint.point + 2.0 * self.shape.unit * front - origin)
        handle = self._add_unseen(
            node("links", joint.child, f"effort {joint.name}"), meshes.turn_arrow(RING)
        )
        return Arrow(
            handle, base, rotation.T @ joint.axis, rotation.T @ reach(self.shape.skeleton, joint)
        )

    def _add_shaft(self, joint: PlacedJoint, toward: Array) -> Arrow:
        """Beside what slides."""
        anchor, unit = self.shape.anchors[joint.name], self.shape.unit
        rotation, _ = self.shape.poses(self.shape.home)[anchor.link]
        aside = np.cross(anchor.axis, rotation.T @ toward)
        aside /= max(float(np.linalg.norm(aside)), 1e-9)
        base = anchor.point + unit * (1.9 * aside + 2.4 * np.cross(aside, anchor.axis))
        handle = self._add_unseen(
            node("links", anchor.link, f"effort {joint.name}"), meshes.arrow(0.008)
        )
        return Arrow(handle, base, anchor.axis, None)

    def _add_unseen(self, path: str, mesh: meshes.Mesh) -> viser.MeshHandle:
        return self.scene.add_mesh_simple(
            path, mesh.vertices, mesh.faces, color=rgb(RED), cast_shadow=False, visible=False
        )


def reach(skeleton: Skeleton, joint: PlacedJoint) -> Array:
    """Across the axis of a joint, to what is farthest from it on the link that it turns (3,) [m], in base axes."""
    child = joint.child
    ends = [other.point for other in skeleton.joints if other.parent == child]
    ends += [
        point
        for c in skeleton.closures
        for link, point in zip(c.links, c.points, strict=True)
        if link == child
    ]
    ends += [frame.point for frame in skeleton.frames if frame.link == child]
    arms = np.array([joint.point, *ends]) - joint.point
    arms -= np.outer(arms @ joint.axis, joint.axis)
    lengths = np.linalg.norm(arms, axis=1)
    return np.asarray(arms[lengths.argmax()]) if lengths.max() > ON_AXIS else np.zeros(3)


def node(*parts: str) -> str:
    """The path of a node; names of a robot may have slashes."""
    return "/" + "/".join(part.replace("/", "∕") for part in parts)


def wxyz(rotation: Array) -> Array:
    """Unit quaternion (4,) of a rotation (3, 3)."""
    x, y, z, w = quaternion(rotation)
    return np.array([w, x, y, z])


def rgb(colour: str) -> tuple[int, int, int]:
    """A colour #rrggbb as three numbers to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
