"""Exudyn: trees in minimal coordinates, loops in redundant ones, index 2 trapezoidal rule.

Planar loops are of `RigidBody2D`, others of rigid bodies with Euler parameters, as in Exudyn's own
examples of these problems.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import exudyn
import numpy as np
from exudyn import utilities

from hybrid_dynamics_core.description.model import Closure, Joint

from .model import Model, toward

Array = np.ndarray
NAME = "Exudyn"
PACKAGE = "exudyn"
Rows = Callable[[], Array]
FREE_TURN = [1, 1, 1, 1, 1, 0]
FREE_SLIDE = [1, 1, 0, 1, 1, 1]
FREE_BALL = [1, 1, 1, 0, 0, 0]
Pair = tuple[Array, Array]


class Engine:
    """One model at one step."""

    def __init__(self, model: Model, inner: int) -> None:
        self.model = model
        self.inner = inner

    def run(self) -> tuple[float, Array]:
        """CPU time [s] and rows of what is compared."""
        problem = self.model.problem
        container = exudyn.SystemContainer()
        mbs = container.AddSystem()
        rows = _built(mbs, self.model)
        mbs.Assemble()
        settings = exudyn.SimulationSettings()
        integration = settings.timeIntegration
        integration.numberOfSteps = problem.samples * self.inner
        integration.endTime = problem.end
        integration.verboseMode = 0
        integration.adaptiveStep = False  # a step that fails is reported, not divided without end
        integration.newton.relativeTolerance = 1e-9
        if self.model.closures and not self.model.is_planar:
            integration.newton.relativeTolerance = 1e-6  # as in its own Bricard
        integration.newton.useModifiedNewton = True
        solver = exudyn.DynamicSolverType.TrapezoidalIndex2
        if self.model.closures and self.model.is_planar:  # as in its own four-bars
            solver = exudyn.DynamicSolverType.GeneralizedAlpha
            integration.generalizedAlpha.spectralRadius = 0.95
        settings.displayComputationTime = settings.displayStatistics = False
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = problem.end / problem.samples
        settings.linearSolverType = exudyn.LinearSolverType.EigenDense
        settings.linearSolverSettings.ignoreSingularJacobian = bool(self.model.closures)
        if len(self.model.links) > 40:
            settings.linearSolverType = exudyn.LinearSolverType.EigenSparse
        begin = time.process_time()
        mbs.SolveDynamic(settings, solverType=solver)
        return time.process_time() - begin, rows()


def _built(mbs: Any, model: Model) -> Rows:
    """The bodies, and how to read what is compared."""
    if not model.closures:
        return _tree(mbs, model)
    if model.is_planar:
        return _Planar(mbs, model).rows()
    return _Spatial(mbs, model).rows()


def _tree(mbs: Any, model: Model) -> Rows:
    """A kinematic tree; every joint about or along its own z axis."""
    count = len(model.joints)
    node = mbs.AddNode(
        exudyn.utilities.NodeGenericODE2(
            referenceCoordinates=[0.0] * count,
            initialCoordinates=list(model.s.values()),
            initialCoordinates_t=list(model.ds.values()),
            numberOfODE2Coordinates=count,
        )
    )
    numbers = {model.base: -1}
    axes = {model.base: np.eye(3)}
    for k, joint in enumerate(model.joints.values()):
        numbers[joint.child] = k
        axes[joint.child] = toward(joint.axis)
    tree = mbs.AddObject(_kinematic_tree(model, node, numbers, axes))
    for spring in model.springs:
        ends = ((spring.link_a, spring.point_a), (spring.link_b, spring.point_b))
        markers = []
        for name, point in ends:
            marker = utilities.MarkerKinematicTreeRigid(
                objectNumber=tree, linkNumber=numbers[name], localPosition=axes[name].T @ point
            )
            markers.append(mbs.AddMarker(marker))
        _add_spring(mbs, markers, spring)
    kind = exudyn.OutputVariableType
    s, ds = (
        mbs.AddSensor(
            utilities.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=variable)
        )
        for variable in (kind.Coordinates, kind.Coordinates_t)
    )
    return lambda: model.rows(_stored(mbs, s), _stored(mbs, ds))


def _kinematic_tree(
    model: Model, node: Any, numbers: dict[str, int], axes: dict[str, Array]
) -> utilities.ObjectKinematicTree:
    """The object of a tree.

    Args:
        model: the model.
        node: number of the node of its coordinates.
        numbers: number of each link; -1 for the base.
        axes: rotations (3, 3) of frames whose z is the joint's axis, in the frames of the links.
    """
    kinds = {"revolute": exudyn.JointType.RevoluteZ, "prismatic": exudyn.JointType.PrismaticZ}
    rotations, offsets = exudyn.Matrix3DList(), exudyn.Vector3DList()
    inertias, coms = exudyn.Matrix3DList(), exudyn.Vector3DList()
    types, parents, masses = [], [], []
    for joint in model.joints.values():
        link = model.links[joint.child]
        to_joint = axes[joint.child].T
        to_parent_joint = axes[joint.parent].T
        types.append(kinds[joint.type])
        parents.append(numbers[joint.parent])
        rotations.Append(to_parent_joint @ joint.rotation @ axes[joint.child])
        offsets.Append(to_parent_joint @ joint.translation)
        coms.Append(to_joint @ link.com)
        inertias.Append(to_joint @ link.inertia @ axes[joint.child])
        masses.append(link.mass)
    return utilities.ObjectKinematicTree(
        nodeNumber=node,
        jointTypes=types,
        linkParents=parents,
        jointTransformations=rotations,
        jointOffsets=offsets,
        linkInertiasCOM=inertias,
        linkCOMs=coms,
        linkMasses=masses,
        gravity=list(model.description.gravity),
    )


class _Planar:
    """Bodies of three coordinates, and pins between them."""

    def __init__(self, mbs: Any, model: Model) -> None:
        self.mbs = mbs
        self.model = model
        self.bodies = {model.base: mbs.AddObject(utilities.ObjectGround())}
        self.nodes: dict[str, int] = {}
        self.angles = {model.base: 0.0}
        for name, joint in model.joints.items():
            self.angles[joint.child] = self.angles[joint.parent] + joint.axis[2] * model.s[name]
        poses, twists = model.poses(model.s), model.twists(model.s, model.ds)
        for name in model.links:
            self._add_body(name, poses[name], twists[name])
        for joint in model.joints.values():
            self._add_pin(joint.parent, joint.translation, joint.child, np.zeros(3))
        for closure in model.closures:
            self._add_pin(closure.link_a, closure.point_a, closure.link_b, closure.point_b)
        self._add_forces()

    def _add_body(self, name: str, pose: Pair, twist: Pair) -> None:
        """A body with its weight, its node at the centre of mass."""
        link = self.model.links[name]
        arm = pose[0] @ link.com
        rate = twist[1] + np.cross(twist[0], arm)
        node = utilities.NodeRigidBody2D(
            referenceCoordinates=[*(pose[1] + arm)[:2], self.angles[name]],
            initialVelocities=[*rate[:2], twist[0][2]],
        )
        self.nodes[name] = self.mbs.AddNode(node)
        body = utilities.RigidBody2D(
            nodeNumber=self.nodes[name],
            physicsMass=link.mass,
            physicsInertia=link.inertia[2, 2],
        )
        self.bodies[name] = self.mbs.AddObject(body)
        marker = self.mbs.AddMarker(utilities.MarkerBodyMass(bodyNumber=self.bodies[name]))
        gravity = list(self.model.description.gravity)
        self.mbs.AddLoad(utilities.LoadMassProportional(markerNumber=marker, loadVector=gravity))

    def marker(self, link: str, point: Array) -> Any:
        """A point of a link."""
        local = np.array(point)
        if link != self.model.base:
            local = local - self.model.links[link].com
        body = self.bodies[link]
        return self.mbs.AddMarker(utilities.MarkerBodyRigid(bodyNumber=body, localPosition=local))

    def _add_pin(self, link_a: str, point_a: Array, link_b: str, point_b: Array) -> None:
        ends = [self.marker(link_a, point_a), self.marker(link_b, point_b)]
        self.mbs.AddObject(utilities.RevoluteJoint2D(markerNumbers=ends))

    def _add_forces(self) -> None:
        for spring in self.model.springs:
            a = self.marker(spring.link_a, spring.point_a)
            b = self.marker(spring.link_b, spring.point_b)
            _add_spring(self.mbs, [a, b], spring)
        for name, effort in self.model.tau.items():
            place = self.marker(self.model.joints[name].child, np.zeros(3))
            self.mbs.AddLoad(utilities.Torque(markerNumber=place, loadVector=[0, 0, effort]))

    def rows(self) -> Rows:
        """How to read what is compared."""
        if self.model.problem.observed.names:
            return _angles(self.mbs, self.model, self.nodes, self.angles)
        return _point(self.mbs, self.model, self.bodies, self.model.links)


def _angles(mbs: Any, model: Model, nodes: dict[str, int], start: dict[str, float]) -> Rows:
    """Angles of joints, from those of bodies."""
    kind = exudyn.OutputVariableType
    sensors = {}
    for link, node in nodes.items():
        sensors[link] = [
            mbs.AddSensor(
                utilities.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=one)
            )
            for one in (kind.Coordinates, kind.Coordinates_t)
        ]

    def rows() -> Array:
        turned = {link: start[link] + _stored(mbs, a)[:, 2] for link, (a, _) in sensors.items()}
        rates = {link: _stored(mbs, b)[:, 2] for link, (_, b) in sensors.items()}
        count = len(next(iter(rates.values())))
        turned[model.base] = rates[model.base] = np.zeros(count)
        joints = model.joints.values()
        s = [one.axis[2] * (turned[one.child] - turned[one.parent]) for one in joints]
        ds = [one.axis[2] * (rates[one.child] - rates[one.parent]) for one in joints]
        return model.rows(np.array(s).T, np.array(ds).T)

    return rows


def _point(mbs: Any, model: Model, bodies: dict[str, int], centred: Any) -> Rows:
    """Place and rate of the end effector's point."""
    kind = exudyn.OutputVariableType
    frame = model.description.frames[model.description.end_effector]
    local = np.array(frame.translation)
    if frame.link in centred:
        local = local - centred[frame.link].com
    place, rate = (
        mbs.AddSensor(
            utilities.SensorBody(
                bodyNumber=bodies[frame.link],
                localPosition=local,
                storeInternal=True,
                outputVariableType=variable,
            )
        )
        for variable in (kind.Position, kind.Velocity)
    )

    def rows() -> Array:
        pairs = zip(_stored(mbs, place), _stored(mbs, rate), strict=True)
        return np.array([model.observe(p, v) for p, v in pairs])

    return rows


class _Spatial:
    """Rigid bodies with Euler parameters; a massless cross becomes a universal joint."""

    def __init__(self, mbs: Any, model: Model) -> None:
        self.mbs = mbs
        self.model = model
        self.poses = model.poses(model.s)
        self.bodies = {model.base: mbs.CreateGround()}
        self.heavy = {name: link for name, link in model.links.items() if link.mass}
        twists = model.twists(model.s, model.ds)
        for name in self.heavy:
            self._add_body(name, twists[name])
        self.parents = {joint.child: joint for joint in model.joints.values()}
        for link in self.heavy:
            self._add_joint(self.parents[link])
        for closure in model.closures:
            self._add_closure(closure)

    def _add_body(self, name: str, twist: Pair) -> None:
        link = self.heavy[name]
        R, p = self.poses[name]
        self.bodies[name] = self.mbs.CreateRigidBody(
            inertia=utilities.RigidBodyInertia(mass=link.mass, inertiaTensor=link.inertia),
            referencePosition=p + R @ link.com,
            referenceRotationMatrix=R,
            initialVelocity=twist[1] + np.cross(twist[0], R @ link.com),
            initialAngularVelocity=twist[0],
            gravity=list(self.model.description.gravity),
        )

    def _add(self, a: str, b: str, place: Array, axes: Array, fixed: list[int]) -> None:
        """A joint whose axes are the columns of `axes`, in the world."""
        self.mbs.CreateGenericJoint(
            bodyNumbers=[self.bodies[a], self.bodies[b]],
            position=place,
            rotationMatrixAxes=axes,
            constrainedAxes=fixed,
            useGlobalFrame=True,
            show=False,
        )

    def _add_joint(self, joint: Joint) -> None:
        R, p = self.poses[joint.child]
        axis = R @ joint.axis
        if joint.parent in self.bodies:
            fixed = FREE_TURN if joint.type == "revolute" else FREE_SLIDE
            self._add(joint.parent, joint.child, p, toward(axis), fixed)
            return
        cross = self.parents[joint.parent]
        first = self.poses[cross.child][0] @ cross.axis
        axes = np.column_stack([np.cross(first, axis), first, axis])
        self._add(cross.parent, joint.child, p, axes, [1, 1, 1, 1, 0, 0])

    def _add_closure(self, closure: Closure) -> None:
        R, p = self.poses[closure.link_a]
        place = p + R @ closure.point_a
        axes, fixed = np.eye(3), FREE_BALL
        if closure.kind == "axis":
            axes, fixed = toward(R @ closure.rotation_a[:, 2]), FREE_TURN
        self._add(closure.link_a, closure.link_b, place, axes, fixed)

    def rows(self) -> Rows:
        """How to read what is compared."""
        return _point(self.mbs, self.model, self.bodies, self.heavy)


def _add_spring(mbs: Any, markers: list[int], spring: Any) -> None:
    mbs.AddObject(
        utilities.SpringDamper(
            markerNumbers=markers,
            referenceLength=spring.rest,
            stiffness=spring.stiffness,
            damping=spring.damping,
        )
    )


def _stored(mbs: Any, sensor: int) -> Array:
    """Values of a sensor, without the column of times."""
    return np.asarray(mbs.GetSensorStoredData(sensor)[:, 1:])
