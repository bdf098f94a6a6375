"""HyRoDyn's submechanisms and generalized_rbda's clusters, from one file each.

Efforts come from inverse dynamics here. Under these efforts Pinocchio and MuJoCo, where they are
installed, have to find the accelerations that were asked:

    python examples/peers/submechanisms.py

Pinocchio gets the open tree and the loops as constraints. MuJoCo gets the exported MJCF, whose
loops are soft.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot, load
from hybrid_dynamics_core.export import to_mjcf

FOLDER = Path(__file__).parent
HYRODYN = {
    "parallelogram": "parallelogram chain",
    "rrpr": "1-RRPR",
    "spu2_u1": "2-SPU+1U",
    "sprr2_u1": "2-SPRR+1U",
    "ups6": "6-UPS",
    "r3_ss2": "3-R[2-SS]",
    "transmission": "transmission",
}
GENERALIZED_RBDA = {
    "four_bar": "four-bar",
    "planar_leg": "planar leg linkage",
    "rotor_1": "revolute with rotor",
    "rotor_2": "revolute pair with rotors",
    "rotor_3": "revolute triple with rotors",
    "tello_hip": "Tello hip, implicit",
    "tello_knee_ankle": "Tello knee and ankle, implicit",
}
TITLES = HYRODYN | GENERALIZED_RBDA
RATE, ACCELERATION = 0.3, 1.0  # [rad/s or m/s], and a second, of the first drive
Array = np.ndarray


def moving(robot: Robot) -> tuple[ClosedState, Array]:
    """A moving state, and accelerations of the drives."""
    fading = 0.8 ** np.arange(len(robot.active))
    state = robot.close(robot.reference, RATE * fading)
    return state, ACCELERATION * fading


def with_pinocchio(robot: Robot, state: ClosedState, tau: Array) -> Array:
    """Accelerations of the drives, by Pinocchio's tree and its loops as constraints."""
    pin = importlib.import_module("pinocchio")
    model, links = tree(pin, robot)
    order = [model.joints[model.getJointId(name)].idx_v for name in robot.coordinates]
    q, v, force = (np.zeros(model.nv) for _ in range(3))
    q[order], v[order] = state.s, state.ds
    force[order[: len(tau)]] = tau
    ends = loop_ends(pin, model, robot, links)
    data = model.createData()
    M = pin.crba(model, data, q)
    bias = pin.nonLinearEffects(model, data, q, v)
    pin.computeJointJacobians(model, data, q)
    pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
    pin.updateFramePlacements(model, data)
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    rows, drift = [], []
    for a, b in ends:
        both = [pin.getFrameJacobian(model, data, frame, world)[:3] for frame in (a, b)]
        rows.append(both[0] - both[1])
        pushed = [pin.getFrameClassicalAcceleration(model, data, f, world).linear for f in (a, b)]
        drift.append(pushed[0] - pushed[1])
    for name, mimic in robot.description.mimics.items():
        row = np.zeros(model.nv)
        row[order[robot.coordinates.index(name)]] = 1.0
        for leader, ratio in mimic.multipliers.items():
            row[order[robot.coordinates.index(leader)]] = -ratio
        rows.append(row[None])
        drift.append(np.zeros(1))
    K, k = np.vstack(rows), np.concatenate(drift)
    count = len(K)
    system = np.block([[M, K.T], [K, np.zeros((count, count))]])
    answer = np.linalg.lstsq(system, np.concatenate([force - bias, -k]), rcond=1e-12)[0]
    return np.asarray(answer[order[: len(tau)]])


def tree(pin: Any, robot: Robot) -> tuple[Any, dict[str, int]]:
    """The open tree in Pinocchio, and the joint of each link."""
    kinds = {
        "revolute": pin.JointModelRevoluteUnaligned,
        "prismatic": pin.JointModelPrismaticUnaligned,
    }
    model = pin.Model()
    model.gravity.linear = np.array(robot.description.gravity)
    links = {robot.description.base: 0}

    def add(parent: str) -> None:
        for name, joint in robot.description.joints.items():
            if joint.parent != parent:
                continue
            placement = pin.SE3(np.array(joint.rotation), np.array(joint.translation))
            kind = kinds[joint.type](np.array(joint.axis))
            index = model.addJoint(links[parent], kind, placement, name)
            link = robot.description.links[joint.child]
            inertia = pin.Inertia(link.mass, np.array(link.com), np.array(link.inertia))
            model.appendBodyToJoint(index, inertia, pin.SE3.Identity())
            links[joint.child] = index
            add(joint.child)

    add(robot.description.base)
    return model, links


def loop_ends(pin: Any, model: Any, robot: Robot, links: dict[str, int]) -> list[tuple[int, int]]:
    """Frames of the points that each loop ties; all loops here tie points."""
    pairs = []
    for closure in robot.description.closures:
        frames = []
        for link, point in (
            (closure.link_a, closure.point_a),
            (closure.link_b, closure.point_b),
        ):
            placement = pin.SE3(np.eye(3), np.array(point))
            name = f"{closure.name} {link}"
            frame = pin.Frame(name, links[link], placement, pin.FrameType.OP_FRAME)
            frames.append(model.addFrame(frame))
        pairs.append((frames[0], frames[1]))
    return pairs


def with_mujoco(robot: Robot, state: ClosedState, tau: Array) -> Array:
    """Accelerations of the drives, by MuJoCo from the exported MJCF."""
    mujoco = importlib.import_module("mujoco")
    model = mujoco.MjModel.from_xml_string(to_mjcf(robot))
    data = mujoco.MjData(model)
    for name, value, rate in zip(robot.coordinates, state.s, state.ds, strict=True):
        joint = model.joint(name)
        data.qpos[joint.qposadr[0]] = value
        data.qvel[joint.dofadr[0]] = rate
    places = [model.joint(name).dofadr[0] for name in robot.active]
    data.qfrc_applied[places] = tau
    mujoco.mj_forward(model, data)
    return np.array(data.qacc[places])


ENGINES = {"pinocchio": with_pinocchio, "mujoco": with_mujoco}


def compared(name: str) -> dict[str, Any]:
    """Efforts of a mechanism, and the largest relative error of each engine's accelerations."""
    robot = load(FOLDER / f"{name}.yaml")
    state, ddu = moving(robot)
    tau = robot.inverse_dynamics(state, ddu)
    result: dict[str, Any] = {"robot": robot, "state": state, "tau": tau, "errors": {}}
    for engine, accelerations in ENGINES.items():
        try:
            found = accelerations(robot, state, tau)
        except ImportError:
            continue
        result["errors"][engine] = float(np.abs(found - ddu).max() / np.abs(ddu).max())
    return result


def line(name: str, result: dict[str, Any]) -> str:
    """What is printed of a mechanism."""
    robot = result["robot"]
    errors = ", ".join(f"{engine} {error:.0e}" for engine, error in result["errors"].items())
    efforts = ", ".join(f"{effort:.4g}" for effort in result["tau"])
    counts = f"{len(robot.active)} of {len(robot.coordinates)}"
    return f"{TITLES[name]:32} {counts:8} {errors:32} {efforts}"


def main() -> None:
    """Compare and print all of them."""
    print(f"{'mechanism':32} {'driven':8} {'error of accelerations':32} efforts [N m or N]")
    for name in TITLES:
        print(line(name, compared(name)))


if __name__ == "__main__":
    main()
