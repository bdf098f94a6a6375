"""The class `Robot`: names, checked arrays, errors with evidence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..capability import capability_at
from ..description.actuators import HydraulicCylinder
from ..description.model import JointType, RobotDescription
from ..dynamics.loads import Loads
from ..ground.arrays import Array
from ..ground.lazy import lazy
from ..kinematics.ik_batch import inverse_kinematics
from ..kinematics.pose_chain import PoseChain
from ..kinematics.workspace import find_workspace
from ..limits import limit_margins
from ..retiming import point_to_point, retime
from ..stiffness import stiffness_at
from .actuation import Actuation
from .closure import Closure
from .compiled_calls import RobotKernels
from .delegate import delegate
from .dynamics import Dynamics
from .joint_poses import JointPoses
from .kernel_store import KernelStore
from .kinematics import Kinematics
from .model import RobotModel
from .motion.motions import Motions
from .parameters import FreeParameters, with_parameters
from .passing import SingularPlaces, better_coordinates, with_active
from .proofs import Certification

if TYPE_CHECKING:
    from .frameworks.casadi_calls import CasadiCalls
    from .frameworks.jax_calls import JaxCalls
    from .frameworks.torch_calls import TorchCalls


class Robot:
    """A hybrid robot: closure, kinematics and minimal-form dynamics from the active coordinates.

    The active coordinates are u (n,), or (N, n) for a batch. Their order is u = `active`,
    z = `passive`, s = `coordinates` = [u; z]. All values are in SI units, radians and base axes.

    A robot is made of parts: the model, the kernels, closure, kinematics, dynamics and actuation.
    Its methods are those of its parts.
    """

    def __init__(self, description: RobotDescription) -> None:
        self._model = RobotModel.from_description(description)
        self._kernels = KernelStore(self._model)
        self._closure = Closure(self._model, self._kernels)
        self._kinematics = Kinematics(self._model, self._kernels, self._closure)
        self._dynamics = Dynamics(self._model, self._kernels, self._closure)
        self._motions = Motions(self._closure, self._dynamics)
        self._actuation = Actuation(self._model, self._closure)
        self._joint_poses = JointPoses(self._model, self._closure)
        self._parameters = FreeParameters(self._model, self._closure)
        self._certification = Certification(self._model, self._closure)
        self._singular_places = SingularPlaces(self._model, self._closure)

    def __reduce__(self) -> tuple[type[Robot], tuple[RobotDescription]]:
        """Pickle and copy by the description."""
        return type(self), (self.description,)

    def __repr__(self) -> str:
        return f"Robot('{self.name}', active={list(self.active)}, passive={list(self.passive)})"

    with_parameters = with_parameters  # functions of the robot
    with_active = with_active
    free = delegate("_parameters", FreeParameters.free)

    # -- names and limits

    @property
    def description(self) -> RobotDescription:
        """The description, with the independent coordinates as active ones."""
        return self._model.description

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self._model.name

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the active coordinates u."""
        return self._model.active

    @property
    def passive(self) -> tuple[str, ...]:
        """Names of the passive coordinates z."""
        return self._model.passive

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates s = [u; z]."""
        return self._model.coordinates

    @property
    def idle(self) -> tuple[str, ...]:
        """Names of active coordinates without a drive."""
        return self._model.idle

    @property
    def dependent_motors(self) -> tuple[str, ...]:
        """Motors that depend on the other ones, and so are passive coordinates."""
        return self._model.dependent_motors

    @property
    def joint_types(self) -> Mapping[str, JointType]:
        """'revolute' or 'prismatic' by coordinate name, in the order of `coordinates`."""
        return self._model.joint_types

    @property
    def base_frame(self) -> str:
        """Name of the base link, in whose frame poses are given."""
        return self.description.base

    @property
    def end_effector(self) -> str:
        """Name of the end-effector frame."""
        return self.description.end_effector

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of all frames and links."""
        return self._model.frames

    @property
    def loops(self) -> tuple[str, ...]:
        """Names of the loops, or of groups that close together, in solving order.

        Names of a group are joined by +.
        """
        return self._model.loops

    @property
    def redundant_equations(self) -> Mapping[str, int]:
        """Number of redundant equations by loop."""
        return self._model.redundant_equations

    @property
    def measured_at_reference(self) -> bool:
        """Whether distances to singularities depend on the reference.

        They do where no link of a loop has a length, and no slide limits: only the reference has a
        length that radians can be compared with.
        """
        return self._model.measured_at_reference

    @property
    def reference(self) -> Array:
        """Active coordinates (n,) of the description's reference configuration [rad, m]."""
        return self._model.reference

    @property
    def limits(self) -> Array:
        """Lower and upper limit (n, 2) of each active coordinate [rad, m], infinite if none.

        They are the intersection of three ranges: the limits of the description, the
        `closing_range`, and the range in which all joints that follow this one alone are within
        their limits. Joints of loops that are closed by iteration do not narrow it.
        """
        return self._model.limits

    @property
    def effort_limits(self) -> Array:
        """Largest effort (n,) of each active joint [N m, N], infinite if none is given.

        They are for planning and control. Dynamics and simulation do not apply them.
        """
        return self._model.effort_limits

    @property
    def velocity_limits(self) -> Array:
        """Largest rate (n,) of each active joint [rad/s, m/s], infinite if none is given."""
        return self._model.velocity_limits

    @property
    def power_limits(self) -> Array:
        """Largest power (n,) of the drive of each active joint [W], infinite if none is given."""
        return self._model.power_limits

    @property
    def closing_range(self) -> Array:
        """Range (n, 2) of each active coordinate between the toggle points of its loop [rad, m].

        It is infinite for a coordinate in no loop, or in a loop with other given coordinates.
        """
        return self._model.closing_range

    loop_distances = delegate("_model", RobotModel.loop_distances)

    # -- closure

    close = delegate("_closure", Closure.close)
    closed_state = delegate("_closure", Closure.closed_state)
    close_path = delegate("_closure", Closure.close_path)
    close_given = delegate("_closure", Closure.close_given)
    follow_turns = delegate("_closure", Closure.follow_turns)
    assembly_modes = delegate("_closure", Closure.assembly_modes)
    certify = delegate("_certification", Certification.certify)
    certify_cells = delegate("_certification", Certification.certify_cells)
    owns = delegate("_closure", Closure.owns)

    @property
    def mode_names(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the assembly modes of each loop that has a closed form.

        The modes of the other loops have only numbers.
        """
        return self._model.mode_names

    @property
    def follows(self) -> bool:
        """Whether a loop has no closed form.

        Its assembly mode is that of the state from which it is followed.
        """
        return self._model.follows

    @property
    def depends_on_turns(self) -> bool:
        """Whether a loop closes otherwise after a whole turn of a passive joint.

        So does a loop behind a gear on that joint. Only a motion from a state before shows it.
        """
        return self._model.plan.depends_on_turns

    # -- singular places that a motion passes

    better_coordinates = better_coordinates  # a function of the robot

    @property
    def singular_places(self) -> SingularPlaces:
        """Change points and toggles ahead of a state, and states beside such a place."""
        return self._singular_places

    # -- ball and free joints

    close_at_poses = delegate("_joint_poses", JointPoses.close_at_poses)
    in_urdf_angles = delegate("_joint_poses", JointPoses.in_urdf_angles)
    joint_pose = delegate("_joint_poses", JointPoses.joint_pose)
    joint_twist = delegate("_joint_poses", JointPoses.joint_twist)
    recentred = delegate("_joint_poses", JointPoses.recentred)
    twist_map = delegate("_joint_poses", JointPoses.twist_map)

    @property
    def middle_turns(self) -> list[int]:
        """Index in s of each ball or free joint's second angle, which is singular at +-pi/2."""
        return self._model.middle_turns

    # -- kinematics

    forward_kinematics = delegate("_kinematics", Kinematics.forward_kinematics)
    jacobian = delegate("_kinematics", Kinematics.jacobian)
    accelerations = delegate("_kinematics", Kinematics.accelerations)

    @property
    def pose_chain(self) -> PoseChain | None:
        """The end effector's coordinates, if its pose determines them in closed form.

        None if inverse kinematics has no closed form by such coordinates.
        """
        return self._kinematics.pose_chain

    inverse_kinematics = inverse_kinematics  # functions of the robot
    workspace = find_workspace

    # -- dynamics

    @property
    def loads(self) -> Loads:
        """What acts besides the actuators, as the description says.

        They are gravity, payloads, friction, rotors and springs.
        """
        return self._dynamics.loads

    inverse_dynamics = delegate("_dynamics", Dynamics.inverse_dynamics)
    forward_dynamics = delegate("_dynamics", Dynamics.forward_dynamics)
    inverse_dynamics_derivatives = delegate("_dynamics", Dynamics.inverse_dynamics_derivatives)
    forward_dynamics_derivatives = delegate("_dynamics", Dynamics.forward_dynamics_derivatives)
    minimal_form = delegate("_dynamics", Dynamics.minimal_form)
    passive_forces = delegate("_dynamics", Dynamics.passive_forces)
    regressor = delegate("_dynamics", Dynamics.regressor)
    motion_near = delegate("_motions", Motions.motion_near)
    motion_steps = delegate("_motions", Motions.motion_steps)
    centroidal = delegate("_dynamics", Dynamics.centroidal)
    energy = delegate("_dynamics", Dynamics.energy)
    coriolis_matrix = delegate("_dynamics", Dynamics.coriolis_matrix)
    velocity_map_rate = delegate("_dynamics", Dynamics.velocity_map_rate)
    spanning_terms = delegate("_dynamics", Dynamics.spanning_terms)
    reactions = delegate("_dynamics", Dynamics.reactions)

    # -- actuation

    @property
    def cylinders(self) -> Mapping[str, HydraulicCylinder]:
        """The hydraulic cylinders of the description, by joint."""
        return self._actuation.cylinders

    @property
    def drives(self) -> tuple[str, ...]:
        """Driven joints that determine the motion, in the order of the coordinates.

        Joints with an actuator come first, then active joints until all but the idle coordinates
        are determined.
        """
        return self._actuation.drives

    @property
    def all_drives(self) -> tuple[str, ...]:
        """All driven joints, including redundant ones, in the order of the coordinates."""
        return self._actuation.all_drives

    @property
    def effort_ranges(self) -> Mapping[str, tuple[float, float]]:
        """Least and greatest effort of each of `all_drives` [N m, N], infinite without a limit.

        They are effort limits, and pressures of cylinders.
        """
        return self._actuation.effort_ranges

    @property
    def rate_ranges(self) -> Mapping[str, float]:
        """Largest rate of each coordinate [rad/s, m/s], infinite without a limit."""
        joints = self.description.joints
        return {name: joints[name].velocity_limit for name in self.coordinates}

    capability = capability_at  # functions of the robot
    stiffness = stiffness_at
    limit_margins = limit_margins
    retime = retime
    point_to_point = point_to_point
    drive_rates = delegate("_actuation", Actuation.drive_rates)
    distribute = delegate("_actuation", Actuation.distribute)
    generalised_forces = delegate("_actuation", Actuation.generalised_forces)
    drive_forces = delegate("_actuation", Actuation.drive_forces)
    hydraulics = delegate("_actuation", Actuation.hydraulics)

    # -- kernels

    @lazy
    def kernels(self) -> RobotKernels:
        """Compiled calls, from active coordinates to a result, for the least overhead."""
        return RobotKernels(self._kernels, self._closure, self._dynamics, self.loads)

    @lazy
    def jax(self) -> JaxCalls:
        """The calls as pure functions of JAX, with exact derivatives.

        Raises:
            InputError: JAX is not installed.
        """
        from .frameworks.jax_calls import JaxCalls  # noqa: PLC0415  JAX is an extra

        return JaxCalls(self._closure, self._dynamics, self.loads)

    @lazy
    def torch(self) -> TorchCalls:
        """The calls in PyTorch, with exact derivatives.

        Raises:
            InputError: PyTorch is not installed.
        """
        from .frameworks.torch_calls import TorchCalls  # noqa: PLC0415  PyTorch is an extra

        return TorchCalls(self._closure, self._dynamics, self.loads)

    @lazy
    def casadi(self) -> CasadiCalls:
        """The calls as Functions of CasADi, for optimal control.

        Raises:
            InputError: CasADi is not installed.
        """
        from .frameworks.casadi_calls import CasadiCalls  # noqa: PLC0415  CasADi is an extra

        return CasadiCalls(self._closure, self._dynamics, self.loads)

    kernel = delegate("_kernels", KernelStore.kernel)
