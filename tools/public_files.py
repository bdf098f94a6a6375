"""Load all robot files of some folders; where MuJoCo or Pinocchio takes one too, compare both.

python tools/public_files.py FOLDER... [--ext .xml .mjcf] [--most 60] [--out table.tsv]

Each file is tried in a process of its own. It prints how many load, are refused and why, and how
many of those that load agree with MuJoCo in mass matrix, weight and inverse dynamics at three
closed states. Files with more freedoms than `--most` are loaded and not compared. Lines of the
table: file, outcome, freedoms, largest relative difference, reason.

`--ext .urdf .yaml` compares URDF, URDF+ and robot.yaml files with Pinocchio: the same numbers, and
what couplings and loops miss in position, velocity and acceleration. A robot.yaml of Gepetto's has
its URDF beside it.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.formats.reader import read_description

NEAR = 1e-9  # relative difference that counts as none
SECONDS = 120  # for one file
ROOTS = {
    ".xml": "<mujoco",
    ".mjcf": "<mujoco",
    ".urdf": "<robot",
    ".sdf": "<sdf",
    ".yaml": "name_mot",
}
PINOCCHIOS = (".urdf", ".yaml")


def main() -> int:
    """Try all files."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--ext", nargs="*", default=[".xml", ".mjcf"])
    parser.add_argument("--most", type=int, default=60)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--one", action="store_true")
    arguments = parser.parse_args()
    if arguments.one:
        print("\t".join(tried(arguments.folders[0], arguments.most)))
        return 0
    rows = []
    for file in files(arguments.folders, arguments.ext):
        row = [str(file), *in_a_process(file, arguments.most)]
        rows.append(row)
        if arguments.out:
            arguments.out.write_text("\n".join("\t".join(row) for row in rows) + "\n")
    counts = Counter(row[1] for row in rows)
    print(dict(counts))
    reasons = Counter(kind_of(row[-1]) for row in rows if row[1] not in ("agrees", "not MuJoCo's"))
    for reason, count in reasons.most_common():
        print(f"{count:5d}  {reason}")
    return 0


def files(folders: list[Path], endings: list[str]) -> list[Path]:
    """Files of robots by their endings and roots."""
    listed = []
    for folder in folders:
        for file in sorted(folder.rglob("*")):
            if file.suffix in endings and file.is_file():
                text = file.read_text(encoding="utf-8", errors="replace")
                if ROOTS.get(file.suffix, "") in text:
                    listed.append(file)
    return listed


def in_a_process(file: Path, most: int) -> list[str]:
    """What comes of a file, whatever happens to the process."""
    command = [sys.executable, __file__, "--one", "--most", str(most), str(file)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return ["hangs", "", "", f"more than {SECONDS} s"]
    lines = done.stdout.strip().splitlines()
    if done.returncode or not lines:
        last = done.stderr.strip().splitlines()[-1:] or [f"ended with {done.returncode}"]
        return ["fails", "", "", last[0]]
    return lines[-1].split("\t")


def tried(file: Path, most: int) -> list[str]:
    """Outcome, freedoms, largest difference and reason."""
    expected = None
    if file.suffix in PINOCCHIOS:
        return tried_in_pinocchio(file, most)
    if ROOTS[file.suffix] == "<mujoco":
        expected, reason = mujoco_model(file)
        if expected is None:
            return ["not MuJoCo's", "", "", reason]
        if expected.nv == 0:
            return ["not MuJoCo's", "0", "", "nothing moves"]
    try:
        return loaded(file, most, expected)
    except HybridDynamicsError as error:
        return ["refused", str(getattr(expected, "nv", "")), "", " ".join(str(error).split())]


def loaded(file: Path, most: int, expected: Any) -> list[str]:
    """Load a file and compare it."""
    robot = robot_of(file, coulomb=0.0)
    count = len(robot.coordinates)
    if expected is None or count > most:
        return ["loads, not compared", str(count), "", "" if expected is None else "too many"]
    differences = [difference(robot, expected, seed) for seed in range(3)]
    largest = max(differences)
    outcome = "agrees" if largest < NEAR else "differs"
    return [outcome, str(count), f"{largest:.2g}", "differs" if outcome == "differs" else ""]


def robot_of(file: Path, **effects: float) -> Robot:
    """The robot of a file, with some effects of all its joints as given."""
    description = read_description(file)
    changed = {}
    for name, effect in description.effects.items():
        changed[name] = replace(effect, **effects)
    return Robot(replace(description, effects=changed))


# -- Pinocchio


def tried_in_pinocchio(file: Path, most: int) -> list[str]:
    """Outcome, freedoms, largest difference and reason, without springs and dry friction."""
    from pinocchio_files import PinocchioFile  # noqa: PLC0415
    from pinocchio_motion import NotComparedError, difference  # noqa: PLC0415

    try:
        robot = robot_of(file, coulomb=0.0, stiffness=0.0, preload=0.0)
    except HybridDynamicsError as error:
        return ["refused", "", "", " ".join(str(error).split())]
    count = len(robot.coordinates)
    if count > most:
        return ["loads, not compared", str(count), "", "too many"]
    try:
        other = PinocchioFile(file)
        pairs = [difference(robot, other, closed_state(robot, seed)) for seed in range(3)]
    except (NotComparedError, ValueError) as error:
        return ["loads, not compared", str(count), "", " ".join(str(error).split())]
    largest = max(max(pair) for pair in pairs)
    if largest < NEAR:
        return ["agrees", str(count), f"{largest:.2g}", ""]
    return ["differs", str(count), f"{largest:.2g}", f"differs by {pairs}"]


# -- MuJoCo


def mujoco_model(file: Path) -> tuple[Any, str]:
    """The compiled model, without pictures and meshes where these are not there."""
    reason = ""
    for strip in (kept, without_pictures, without_files):
        try:
            spec = mujoco.MjSpec.from_file(str(file))
            spec.compiler.LRopt.mode = 0
            spec.compiler.fusestatic = False
            strip(spec)
            return spec.compile(), ""
        except (ValueError, RuntimeError) as error:
            reason = " ".join(str(error).split())
    return None, reason


def kept(spec: Any) -> None:
    """Leave all as it is."""


def without_pictures(spec: Any) -> None:
    """Take out pictures. Meshes stay, since bodies may have their masses."""
    for geom in spec.geoms:
        geom.material = ""
    for kind in ("sites", "tendons"):
        for element in getattr(spec, kind):
            element.material = ""
    for kind in ("skins", "materials", "textures"):
        for element in list(getattr(spec, kind)):
            spec.delete(element)


def without_files(spec: Any) -> None:
    """Take out all that comes from files."""
    without_pictures(spec)
    from_files = (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_HFIELD)
    for geom in list(spec.geoms):
        if geom.meshname or geom.type in from_files:
            spec.delete(geom)
    for kind in ("sensors", "pairs", "excludes", "meshes", "hfields"):
        for element in list(getattr(spec, kind)):
            spec.delete(element)


def difference(robot: Any, model: Any, seed: int) -> float:
    """Largest relative difference of mass matrix, weight and inverse dynamics at a closed state."""
    state = closed_state(robot, seed)
    data = mujoco.MjData(model)
    compared = Compared(robot, model, data, state)
    ours = robot.minimal_form(state)[0]
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    to_u = compared.rates @ state.R
    theirs = to_u.T @ mass @ to_u
    differences = [relative(ours, theirs)]
    still = robot.close(state.u)
    data.qvel[:] = 0.0
    mujoco.mj_forward(model, data)
    weight = to_u.T @ (data.qfrc_bias - passive(data))
    held = robot.inverse_dynamics(still, np.zeros(len(state.u)))
    differences.append(relative(held, weight))
    if compared.is_plain:
        data.qvel[:] = compared.rates @ state.ds
        mujoco.mj_forward(model, data)
        acceleration = compared.rates @ robot.accelerations(state, np.ones(len(state.u)))
        forces = mass @ acceleration + data.qfrc_bias - passive(data)
        efforts = robot.inverse_dynamics(state, np.ones(len(state.u)))
        differences.append(relative(efforts, to_u.T @ forces))
    return max(differences)


def passive(data: Any) -> Any:
    """Passive forces without the drag of a fluid, which is left out here, with a note."""
    return data.qfrc_passive - data.qfrc_fluid


def closed_state(robot: Any, seed: int) -> Any:
    """A closed state near the reference."""
    rng = np.random.default_rng(seed)
    start = robot.reference
    rates = rng.uniform(-1.0, 1.0, len(start))
    for size in (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4):
        try:
            return robot.close(start + rng.uniform(-size, size, len(start)), rates)
        except HybridDynamicsError:
            continue
    return robot.close(start, rates)


class Compared:
    """A state of a robot in MuJoCo: coordinates by name, balls and free joints by quaternions."""

    def __init__(self, robot: Any, model: Any, data: Any, state: Any) -> None:
        self.columns = {name: k for k, name in enumerate(robot.coordinates)}
        self.s = state.s
        self.poses = {
            joint.name: robot.joint_pose(state, joint.name)
            for joint in robot.description.freely_turning
        }
        self.rates = np.zeros((model.nv, len(state.s)))
        self.is_plain = True
        mujoco.mj_resetData(model, data)
        self.names = joint_names(model)
        for number in self.names:
            self.place(model, data, number)
        for number in range(model.neq):
            held = model.eq_type[number] == mujoco.mjtEq.mjEQ_JOINT
            if held and model.eq_obj2id[number] < 0 and model.eq_active0[number]:
                joint = model.eq_obj1id[number]
                address = model.jnt_qposadr[joint]
                data.qpos[address] = model.qpos0[address] + model.eq_data[number][0]
        data.qvel[:] = self.rates @ state.ds
        mujoco.mj_forward(model, data)

    def place(self, model: Any, data: Any, number: int) -> None:
        """Set the coordinates of one joint, and the map from rates to velocities."""
        joint = model.joint(number)
        name = self.names[number]
        first, dof = joint.qposadr[0], joint.dofadr[0]
        if joint.type[0] > 1:
            if name in self.columns:
                data.qpos[first] = self.s[self.columns[name]]
                self.rates[dof, self.columns[name]] = 1.0
            return
        self.is_plain = False
        names = [f"{name}_r{letter}" for letter in "xyz"]
        start = np.eye(3)
        if joint.type[0] == 0:
            body = model.body(joint.bodyid[0])
            start = turn(body.quat)
            slides = [self.columns[f"{name}_{letter}"] for letter in "xyz"]
            data.qpos[first : first + 3] = body.pos + start @ self.poses[name].position
            self.rates[dof : dof + 3, slides] = start
            first, dof = first + 3, dof + 3
        columns = [self.columns[hinge] for hinge in names]
        _, y, z = (about(k, self.s[column]) for k, column in enumerate(columns))
        data.qpos[first : first + 4] = quaternion(start @ self.poses[name].rotation)
        axes = np.column_stack([z.T @ y.T @ [1.0, 0, 0], z.T @ [0, 1.0, 0], [0, 0, 1.0]])
        self.rates[dof : dof + 3, columns] = axes


def joint_names(model: Any) -> dict[int, str]:
    """Names of joints by number, without those of flexes, which are left out here."""
    flexible = {*model.flex_vertbodyid.tolist(), *model.flex_nodebodyid.tolist()}
    names: dict[int, str] = {}
    for number in range(model.njnt):
        joint = model.joint(number)
        if joint.bodyid[0] not in flexible:
            names[number] = joint.name or f"joint{len(names)}"
    return names


def about(axis: int, angle: float) -> Any:
    """A turn about a coordinate axis."""
    quat = np.zeros(4)
    quat[0], quat[axis + 1] = np.cos(angle / 2.0), np.sin(angle / 2.0)
    return turn(quat)


def turn(quat: Any) -> Any:
    """The matrix of a quaternion."""
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quat, float))
    return matrix.reshape(3, 3)


def quaternion(matrix: Any) -> Any:
    """The quaternion of a matrix."""
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, matrix.ravel())
    return quat


def relative(one: Any, other: Any) -> float:
    """The largest difference over the largest number, or over one."""
    size = max(1e-3, float(np.abs(other).max(initial=0.0)))
    return float(np.abs(np.asarray(one) - other).max(initial=0.0)) / size


def kind_of(reason: str) -> str:
    """A reason without names and numbers."""
    text = re.sub(r"^\S*: ", "", reason)
    text = re.sub(r"'[^']*'", "'..'", text)
    text = re.sub(r"^[\w.\-/\[\]]+: ", "", text)
    return re.sub(r"-?\d+\.?\d*(e-?\d+)?", "#", text)[:110]


if __name__ == "__main__":
    sys.exit(main())
