"""The scene in the browser; meshes are sent once, then only poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import viser

from ..algebra.rotations import quaternion
from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..scene.skeleton import PlacedJoint, Pose, Skeleton, place_skeleton
from ..scene.style import PURPLE, QUIET, RED
from ..scene.visuals.surfaces import NONE, Surfaces
from . import meshes
from .bodies import RobotShape, SolidBody, Span, span_pose
from .camera import Camera, Floor, camera_for, floor_under
from .session import DriveEfforts
from .visuals import Visuals

LONGEST: Final = 0.2  # length of the arrow of a full bar, as a share of the robot's size
RING: Final = 0.065  # thickness of a ring arrow, as a share of its radius
FAINT: Final = 0.02  # share of a full bar below which there is no arrow
ON_AXIS: Final = 1e-9  # [m] distance to an axis that is rounding


@dataclass(frozen=True, eq=False)
class EffortArrow:
    """An arrow of effort.

    Attributes:
        handle: handle of viser.
        base: (3,) its start in link axes [m].
        axis: (3,) its positive direction in link axes.
        opening: (3,) direction of a ring's gap, normal to the axis, or zero for any; None: no ring.
    """

    handle: viser.MeshHandle
    base: Array
    axis: Array
    opening: Array | None

    def frame(self, sign: float) -> Array:
        """Its axes (3, 3) for a positive or negative effort."""
        along = np.copysign(1.0, sign) * self.axis
        if self.opening is None or not self.opening.any():
            return meshes.frame_along(along)
        return meshes.frame_open(along, self.opening)


class SceneView:
    """The scene of one robot on a viser server.

    `show` moves it to a state, `show_efforts` updates its arrows.

    Args:
        server: the server of viser.
        shape: geometry of the robot.
    """

    def __init__(
        self, server: viser.ViserServer, shape: RobotShape, surfaces: Surfaces = NONE
    ) -> None:
        self.server = server
        self.shape = shape
        self.scene = server.scene
        self.links = {}
        for name in shape.skeleton.links:
            path = node("links", name)
            self.links[name] = self.scene.add_frame(path, show_axes=False)
        self.bodies = self._add_bodies()
        self.spans = []
        for k, span in enumerate(shape.spans):
            self.spans.append((span, self._add_span(k, span)))
        paths = {name: handle.name for name, handle in self.links.items()}
        self.visuals = Visuals(self.scene, shape, surfaces, paths)
        self.show_skeleton(False)
        self._add_names()
        self._add_tip()
        points = np.vstack([shape.points, self.visuals.points(shape.poses(shape.reference))])
        self.floor = floor_under(points, shape.unit)
        self.camera = camera_for(shape.skeleton, points)
        self._tiles = self._add_floor(self.floor)
        self._gravity = self._add_gravity()
        self._place_camera()
        self.arrows = {name: self._add_arrow(name) for name in shape.robot.drives}

    # -- updates

    def show(self, state: ClosedState) -> None:
        """Move every link to its pose."""
        self.show_poses(self.shape.poses(state))

    def show_poses(self, poses: Mapping[str, Pose]) -> None:
        """Move every link to a pose, as if joints and closures gave way."""
        with self.server.atomic():
            for name, handle in self.links.items():
                rotation, origin = poses[name]
                handle.position = origin
                handle.wxyz = wxyz(rotation)
            for span, tube in self.spans:
                _stretch(tube, span, poses)

    def points(self, state: ClosedState) -> Array:
        """(k, 3) points of the robot and its visuals in a closed state [m]."""
        skeleton = place_skeleton(self.shape.robot, state)
        return np.vstack([skeleton.points, self.visuals.points(self.shape.poses(state))])

    def show_skeleton(self, skeleton: bool) -> None:
        """Show the skeleton in place of the visuals, or the visuals."""
        with self.server.atomic():
            self.visuals.show(skeleton, [*self.bodies, *self.spans])

    def show_efforts(self, efforts: DriveEfforts) -> None:
        """Update the arrows, along forces or around the axes of torques."""
        shares = dict(zip(efforts.joints, efforts.shares, strict=True))
        with self.server.atomic():
            for name, arrow in self.arrows.items():
                share = shares.get(name, 0.0)
                arrow.handle.visible = abs(share) > FAINT
                if arrow.handle.visible:
                    arrow.handle.position = arrow.base
                    arrow.handle.wxyz = wxyz(arrow.frame(share))
                    size = min(abs(share), 1.0)
                    arrow.handle.scale = self._scale(arrow, size)

    def _scale(self, arrow: EffortArrow, share: float) -> float | tuple[float, float, float]:
        """The scale of an arrow for a share of its full bar."""
        if arrow.opening is not None:
            return float((2.2 + 3.4 * share) * self.shape.unit)
        length = share * LONGEST * self.shape.size
        width = self.shape.size * min(1.0, 0.35 + 0.65 * share)
        return width, width, length

    def surround(self, points: Array, camera: Camera) -> None:
        """Put the floor under the robot, and the gravity arrow into a camera's picture.

        Args:
            points: (k, 3) points of the robot [m]. The floor is never above its initial level.
            camera: camera of new browsers.
        """
        floor = floor_under(points, self.shape.unit)
        level = min(self.floor.level, floor.level)
        x, y, _ = self._tiles.position
        self._tiles.position = np.array([x, y, level])
        if camera is self.camera:
            return
        self.camera = camera
        start = self.server.initial_camera
        start.position = camera.position
        start.look_at = camera.look_at
        if self._gravity is not None:
            self._gravity.position = camera.corner

    # -- objects

    def _add_bodies(self) -> list[tuple[SolidBody, viser.MeshHandle]]:
        handles: list[tuple[SolidBody, viser.MeshHandle]] = []
        for k, body in enumerate(self.shape.bodies):
            handle = self.scene.add_mesh_simple(
                node("links", body.link, f"{k} {body.kind} {'+'.join(body.names)} {body.role}"),
                body.mesh.vertices,
                body.mesh.faces,
                color=rgb(body.colour),
            )
            handles.append((body, handle))
        return handles

    def _add_span(self, k: int, span: Span) -> viser.MeshHandle:
        tube = meshes.tube(span.radius)
        name = node("spans", f"{k} {span.kind} {'+'.join(span.names)}")
        colour = rgb(span.colour)
        return self.scene.add_mesh_simple(name, tube.vertices, tube.faces, color=colour)

    def _add_names(self) -> None:
        """Add the names of the active joints."""
        for name in self.shape.robot.active:
            anchor = self.shape.anchors[name]
            self.scene.add_label(
                node("links", anchor.link, f"name {name}"),
                name,
                position=anchor.point,
                anchor="bottom-left",
                font_screen_scale=1.1,
            )

    def _add_tip(self) -> None:
        """Add the axes of the end effector."""
        unit = self.shape.unit
        tip = self.shape.skeleton.tip
        frame = self.shape.robot.description.frames.get(tip.name)
        rotation, origin = np.eye(3), np.zeros(3)
        if frame is not None:
            rotation, origin = frame.rotation, frame.translation
        self.tip = self.scene.add_frame(
            node("links", tip.link, f"frame {tip.name}"),
            axes_length=7.0 * unit,
            axes_radius=0.35 * unit,
            origin_radius=0.7 * unit,
            origin_color=rgb(PURPLE),
            wxyz=wxyz(rotation),
            position=origin,
        )

    def _add_floor(self, floor: Floor) -> viser.GridHandle:
        x, y, _ = self.camera.look_at.tolist()
        return self.scene.add_grid(
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
            position=(x, y, floor.level),
        )

    def _place_camera(self) -> None:
        """Set the camera of new browsers."""
        start, size = self.server.initial_camera, self.shape.size
        start.position = self.camera.position
        start.look_at = self.camera.look_at
        start.up = np.array([0.0, 0.0, 1.0])
        start.fov = self.camera.field
        start.near = 0.005 * size
        start.far = 100.0 * size

    def _add_gravity(self) -> viser.MeshHandle | None:
        """Add an arrow along gravity, if there is any."""
        gravity = np.asarray(self.shape.robot.description.gravity, dtype=float)
        strength = float(np.linalg.norm(gravity))
        if not strength > 0.0:
            return None
        mesh = meshes.arrow(0.045)
        handle = self.scene.add_mesh_simple(
            "/gravity",
            mesh.vertices,
            mesh.faces,
            color=rgb(QUIET),
            cast_shadow=False,
            scale=0.14 * self.shape.size,
            wxyz=wxyz(meshes.frame_along(gravity / strength)),
            position=self.camera.corner,
        )
        self.scene.add_label("/gravity/name", f"g  {strength:.4g} m/s²", anchor="bottom-center")
        return handle

    # -- arrows of effort

    def _add_arrow(self, name: str) -> EffortArrow:
        """Add an arrow of effort, hidden at first."""
        joints = {joint.name: joint for joint in self.shape.skeleton.joints}
        joint = joints[name]
        toward = self.camera.position - self.camera.look_at
        if joint.type == "revolute":
            return self._add_ring(joint, toward)
        return self._add_shaft(joint, toward)

    def _add_ring(self, joint: PlacedJoint, toward: Array) -> EffortArrow:
        """Add a ring around the axis, in front of the joint.

        Its gap is at the link that the joint turns, and turns with it.
        """
        poses = self.shape.poses(self.shape.reference)
        rotation, origin = poses[joint.child]
        front = np.copysign(1.0, joint.axis @ toward) * joint.axis
        place = joint.point + 2.0 * self.shape.unit * front
        opening = reach(self.shape.skeleton, joint)
        path = node("links", joint.child, f"effort {joint.name}")
        return EffortArrow(
            handle=self._add_hidden(path, meshes.ring_arrow(RING)),
            base=rotation.T @ (place - origin),
            axis=rotation.T @ joint.axis,
            opening=rotation.T @ opening,
        )

    def _add_shaft(self, joint: PlacedJoint, toward: Array) -> EffortArrow:
        """Add an arrow next to a slide."""
        anchor = self.shape.anchors[joint.name]
        poses = self.shape.poses(self.shape.reference)
        rotation, _ = poses[anchor.link]
        aside = np.cross(anchor.axis, rotation.T @ toward)
        aside /= max(float(np.linalg.norm(aside)), 1e-9)
        offset = 1.9 * aside + 2.4 * np.cross(aside, anchor.axis)
        path = node("links", anchor.link, f"effort {joint.name}")
        handle = self._add_hidden(path, meshes.arrow(0.008))
        base = anchor.point + self.shape.unit * offset
        return EffortArrow(handle, base, anchor.axis, None)

    def _add_hidden(self, path: str, mesh: meshes.Mesh) -> viser.MeshHandle:
        return self.scene.add_mesh_simple(
            path,
            mesh.vertices,
            mesh.faces,
            color=rgb(RED),
            cast_shadow=False,
            visible=False,
        )


def _stretch(handle: viser.MeshHandle, span: Span, poses: Mapping[str, Pose]) -> None:
    """Place and scale a tube of unit length as a rod."""
    rotation, start, length = span_pose(span, poses)
    handle.position = start
    handle.wxyz = wxyz(rotation)
    handle.scale = (1.0, 1.0, max(length, 1e-6))


def reach(skeleton: Skeleton, joint: PlacedJoint) -> Array:
    """Vector normal to a joint's axis, to the farthest point of the link that it turns.

    Args:
        skeleton: the skeleton.
        joint: the joint.

    Returns:
        (3,) [m], base axes.
    """
    points = [joint.point, *_points_on(skeleton, joint.child)]
    arms = np.array(points) - joint.point
    arms -= np.outer(arms @ joint.axis, joint.axis)
    lengths = np.linalg.norm(arms, axis=1)
    if not lengths.max() > ON_AXIS:
        return np.zeros(3)
    return np.asarray(arms[lengths.argmax()])


def _points_on(skeleton: Skeleton, link: str) -> list[Array]:
    """Points (3,) of joints, closures and frames on a link [m]."""
    points = [joint.point for joint in skeleton.joints if joint.parent == link]
    for closure in skeleton.closures:
        for end, point in zip(closure.links, closure.points, strict=True):
            if end == link:
                points.append(point)
    points += [frame.point for frame in skeleton.frames if frame.link == link]
    return points


def node(*parts: str) -> str:
    """The path of a node, with slashes in names replaced."""
    escaped = [part.replace("/", "∕") for part in parts]
    return "/" + "/".join(escaped)


def wxyz(rotation: Array) -> Array:
    """Unit quaternion w, x, y, z (4,) of a rotation (3, 3)."""
    x, y, z, w = quaternion(rotation)
    return np.array([w, x, y, z])


def rgb(colour: str) -> tuple[int, int, int]:
    """A colour #rrggbb as three numbers from 0 to 255."""
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red, green, blue
