"""The program of the separate process that compiles MJCF: MuJoCo in isolation.

It is run by its path and imports only MuJoCo, NumPy and the standard library. Its input is the text
of a model with includes inserted, and the meshes that define masses. It opens no file. Resource
limits bound its time and memory. It compiles one model after the other, and ends when idle.
"""

from __future__ import annotations

import importlib.util
import json
import os
import runpy
import sys
from pathlib import Path
from typing import Any, BinaryIO

_MEMORY = 1_000_000_000  # bytes
_MAX_BODIES = 20_000
_WITHOUT_LIMITS = 0  # mode without computed ranges of actuators
_FALSE, _TRUE, _AUTO = range(3)  # values of `inertiafromgeom`
_CLOSE = 1e-9  # relative difference of equal tensors
_FIRST = "<mujoco><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>"
_TRIANGLE = 1e-12  # relative rounding in the triangle inequality of moments
_FREE, _BALL = 0, 1
_MODEL = "model"  # prefix of names of attached models, which meshes do not have


class _Compiler:
    """Compiles one model, and returns its content."""

    def __init__(self, text: str, assets: dict[str, bytes]) -> None:
        self.assets = assets
        models = {name: data for name, data in assets.items() if name.startswith(_MODEL)}
        self.spec = mujoco.MjSpec.from_string(text, include=models, assets=assets)
        self.settings = self.spec.compiler
        self.geoms = geoms.Geoms(self.spec)
        self.settings.fusestatic = False  # keeps every body
        self.settings.LRopt.mode = _WITHOUT_LIMITS
        self.bodies: list[Any] = []  # by number in the compiled model
        self.moving: list[bool] = []
        weighs_all = self.settings.settotalmass > 0.0
        self.collect(self.spec.worldbody, weighs_all)
        self.written: dict[int, Any] = {}  # tensor by body number
        self.explicit: dict[int, list[float]] = {}  # mass and principal moments by body number
        self.replaced: set[int] = set()

    def answer(self) -> dict[str, Any]:
        """The content of the model, or the missing meshes."""
        if len(self.bodies) > _MAX_BODIES:
            return {"error": f"has more than {_MAX_BODIES} bodies"}
        missing = self.drop_shapes()
        if missing:
            return {"missing": missing}
        impossible = self.replace_impossible()
        self.model = self.spec.compile()
        if [body.id for body in self.bodies] != list(range(self.model.nbody)):
            return {"error": "has bodies in an order that is not understood"}
        self.restore(impossible)
        return {"model": self.content()}

    def collect(self, body: Any, is_moving: bool) -> None:
        """Collect a body and its descendants, with whether their masses matter."""
        self.bodies.append(body)
        is_moving = is_moving or bool(body.joints)
        self.moving.append(is_moving)
        for child in body.bodies:
            self.collect(child, is_moving)

    # -- shapes

    def drop_shapes(self) -> list[list[str]]:
        """Remove meshes that give no mass; return the other ones that are missing."""
        needed: dict[str, str] = {}
        for number, body in enumerate(self.bodies):
            is_weighed = number > 0 and self.moving[number]
            gives_mass = is_weighed and self.uses_shapes(body)
            for geom in list(body.geoms):
                self.geoms.add(geom)
                geom.contype = geom.conaffinity = 0
                if not self.is_from_file(geom):
                    continue
                if gives_mass and self.has_mass(geom):
                    needed.setdefault(geom.meshname, f"{geom.info}|{body.name}")
                else:
                    self.geoms.hide(geom, number)
        for mesh in list(self.spec.meshes):
            if mesh.name not in needed:
                self.spec.delete(mesh)
        return self.missing(needed)

    def missing(self, needed: dict[str, str]) -> list[list[str]]:
        """File, line and body of each missing mesh."""
        missing: list[list[str]] = []
        for mesh in self.spec.meshes:
            if mesh.file and mesh.file not in self.assets:
                line, _, body = needed[mesh.name].partition("|")
                missing.append([mesh.file, line, body])
        return missing

    def uses_shapes(self, body: Any) -> bool:
        use = self.settings.inertiafromgeom
        return use == _TRUE or (use == _AUTO and not body.explicitinertial)

    def is_from_file(self, geom: Any) -> bool:
        kinds = mujoco.mjtGeom
        of_files = (kinds.mjGEOM_MESH, kinds.mjGEOM_SDF, kinds.mjGEOM_HFIELD)
        return bool(geom.meshname) or geom.type in of_files

    def has_mass(self, geom: Any) -> bool:
        first, last = self.settings.inertiagrouprange
        if not first <= geom.group <= last:
            return False
        if numpy.isnan(geom.mass):
            return bool(geom.density != 0.0)
        return bool(geom.mass != 0.0)

    # -- inertias

    def replace_impossible(self) -> dict[int, Any]:
        """Replace impossible inertias, which MuJoCo would refuse, by those of a ball."""
        replaced: dict[int, Any] = {}
        for number, body in enumerate(self.bodies):
            if number == 0 or self.uses_shapes(body) or not body.explicitinertial:
                continue
            full = numpy.array(body.fullinertia)
            tensor = numpy.diag(body.inertia)
            if not numpy.isnan(full[0]):
                tensor = tensors.tensor_of(full)
                self.written[number] = tensor
            moments = numpy.linalg.eigvalsh(tensor)
            self.explicit[number] = [float(body.mass), *moments.tolist()]
            largest = self.impossible_moment(tensor)
            if largest:
                replaced[number] = tensor
                body.fullinertia = [numpy.nan, 0.0, 0.0, 0.0, 0.0, 0.0]
                body.inertia = numpy.full(3, largest)
        return replaced

    def impossible_moment(self, tensor: Any) -> float:
        """The largest moment of an impossible tensor; 0 for a possible one."""
        if self.settings.balanceinertia or self.settings.settotalmass > 0.0:
            return 0.0
        moments = numpy.linalg.eigvalsh(tensor)
        fits = moments[0] + moments[1] >= moments[2] * (1.0 - _TRIANGLE)
        if fits or moments[0] < 0.0:
            return 0.0
        return float(moments[2])

    def restore(self, replaced: dict[int, Any]) -> None:
        """Restore replaced inertias, in the axes of their bodies."""
        for number, tensor in replaced.items():
            if number not in self.written:
                rotation = tensors.rotation_of(self.model.body_iquat[number])
                self.written[number] = rotation @ tensor @ rotation.T
        self.replaced = set(replaced)

    def inertia(self, number: int) -> Any:
        """The tensor about the centre of mass in body axes; as written if MuJoCo kept it."""
        rotation = tensors.rotation_of(self.model.body_iquat[number])
        principal = numpy.diag(self.model.body_inertia[number])
        compiled = rotation @ principal @ rotation.T
        written = self.written.get(number)
        if written is None:
            return (compiled + compiled.T) / 2.0
        if number in self.replaced:
            return written
        apart = numpy.abs(written - compiled).max()
        if apart <= _CLOSE * numpy.abs(compiled).max():
            return written
        return (compiled + compiled.T) / 2.0

    # -- content

    def content(self) -> dict[str, Any]:
        """The content of the model as plain data."""
        model = self.model
        return {
            "name": self.spec.modelname,
            "bodies": [self.body(body) for body in self.bodies],
            "joints": [self.joint(joint) for joint in _sorted(self.spec.joints)],
            "geoms": self.geoms.content(model),
            "sites": [self.site(site) for site in _sorted(self.spec.sites)],
            "equalities": [self.equality(one) for one in _sorted(self.spec.equalities)],
            "tendons": [self.tendon(tendon) for tendon in _sorted(self.spec.tendons)],
            "actuators": [self.actuator(one) for one in _sorted(self.spec.actuators)],
            "key": model.key_qpos[0].tolist() if model.nkey else [],
            "gravity": model.opt.gravity.tolist(),
            "fluid": [model.opt.density, model.opt.viscosity],
            "disabled": self.disabled(),
            "disabled_groups": [k for k in range(31) if model.opt.disableactuator >> k & 1],
        }

    def disabled(self) -> list[str]:
        flags = mujoco.mjtDisableBit.__members__.items()
        bits = self.model.opt.disableflags
        return [
            name.removeprefix("mjDSBL_").lower()
            for name, flag in flags
            if name.startswith("mjDSBL_") and bits & int(flag)
        ]

    def body(self, body: Any) -> dict[str, Any]:
        model = self.model
        k = body.id
        first = int(model.body_jntadr[k])
        return {
            "name": body.name,
            "line": body.info,
            "parent": int(model.body_parentid[k]),
            "pos": model.body_pos[k].tolist(),
            "quat": model.body_quat[k].tolist(),
            "mass": float(model.body_mass[k]),
            "com": model.body_ipos[k].tolist(),
            "inertia": self.inertia(k).tolist(),
            "is_from_shapes": k > 0 and self.uses_shapes(body) and self.geoms.weigh(body),
            "written": self.explicit.get(k, []),
            "gravity_compensation": float(model.body_gravcomp[k]),
            "is_mocap": bool(model.body_mocapid[k] >= 0),
            "joints": list(range(first, first + int(model.body_jntnum[k]))),
        }

    def joint(self, joint: Any) -> dict[str, Any]:
        model = self.model
        k = joint.id
        dof = int(model.jnt_dofadr[k])
        address = int(model.jnt_qposadr[k])
        kind = int(model.jnt_type[k])
        count = {_FREE: 6, _BALL: 3}.get(kind, 1)
        dofs = slice(dof, dof + count)
        polynomials = (model.jnt_stiffnesspoly[k], *model.dof_dampingpoly[dofs])
        return {
            "name": joint.name,
            "line": joint.info,
            "body": int(model.jnt_bodyid[k]),
            "kind": ("free", "ball", "slide", "hinge")[kind],
            "pos": model.jnt_pos[k].tolist(),
            "axis": model.jnt_axis[k].tolist(),
            "is_limited": bool(model.jnt_limited[k]),
            "range": model.jnt_range[k].tolist(),
            "stiffness": float(model.jnt_stiffness[k]),
            "is_polynomial": bool(numpy.any(numpy.concatenate(polynomials))),
            "spring_yield": float(model.jnt_springyield[k]),
            "has_effort_range": bool(model.jnt_actfrclimited[k]),
            "effort_range": model.jnt_actfrcrange[k].tolist(),
            "is_held_by_drives": bool(model.jnt_actgravcomp[k]),
            "address": address,
            "drawn": float(model.qpos0[address]),
            "spring_reference": float(model.qpos_spring[address]),
            "armature": float(model.dof_armature[dofs].max()),
            "damping": float(model.dof_damping[dofs].max()),
            "frictionloss": float(model.dof_frictionloss[dofs].max()),
        }

    def site(self, site: Any) -> dict[str, Any]:
        model = self.model
        k = site.id
        return {
            "name": site.name,
            "line": site.info,
            "body": int(model.site_bodyid[k]),
            "pos": model.site_pos[k].tolist(),
            "quat": model.site_quat[k].tolist(),
        }

    def equality(self, equality: Any) -> dict[str, Any]:
        model = self.model
        k = equality.id
        kinds = ("connect", "weld", "joint", "tendon")
        kind = int(model.eq_type[k])
        return {
            "name": equality.name,
            "line": equality.info,
            "kind": kinds[kind] if kind < len(kinds) else "other",
            "is_between_sites": int(model.eq_objtype[k]) == int(mujoco.mjtObj.mjOBJ_SITE),
            "ends": [int(model.eq_obj1id[k]), int(model.eq_obj2id[k])],
            "is_active": bool(model.eq_active0[k]),
            "data": model.eq_data[k].tolist(),
        }

    def tendon(self, tendon: Any) -> dict[str, Any]:
        model = self.model
        k = tendon.id
        first = int(model.tendon_adr[k])
        wraps = slice(first, first + int(model.tendon_num[k]))
        columns = (
            model.wrap_type[wraps].tolist(),
            model.wrap_objid[wraps].tolist(),
            model.wrap_prm[wraps].tolist(),
        )
        forces: dict[str, float] = {}
        for word in ("stiffness", "damping", "frictionloss", "armature", "springyield"):
            values = getattr(model, f"tendon_{word}")[k]
            forces[word] = float(numpy.ravel(values)[0])
        for word in ("stiffness", "damping"):
            polynomial = getattr(model, f"tendon_{word}poly")[k]
            forces[f"{word} of higher degree"] = float(numpy.abs(polynomial).max())
        return {
            "name": tendon.name,
            "line": tendon.info,
            "wraps": list(zip(*columns, strict=True)),
            "rest": model.tendon_lengthspring[k].tolist(),
            "length": float(model.tendon_length0[k]),
            "forces": {word: value for word, value in forces.items() if value},
        }

    def actuator(self, actuator: Any) -> dict[str, Any]:
        model = self.model
        k = actuator.id
        kinds = ("joint", "jointinparent", "crank", "tendon", "site", "body")
        kind = int(model.actuator_trntype[k])
        control = int(model.actuator_ctrladr[k])
        is_direct = not (
            model.actuator_gaintype[k] or model.actuator_biastype[k] or model.actuator_dyntype[k]
        )
        return {
            "name": actuator.name,
            "line": actuator.info,
            "kind": kinds[kind] if kind < len(kinds) else "other",
            "target": int(model.actuator_trnid[k][0]),
            "gear": model.actuator_gear[k].tolist(),
            "group": int(model.actuator_group[k]),
            "gain": float(model.actuator_gainprm[k][0]) if is_direct else 0.0,
            "control_range": _limits(model.actuator_ctrllimited, model.actuator_ctrlrange, control),
            "force_range": _limits(model.actuator_forcelimited, model.actuator_forcerange, k),
            "armature": float(model.actuator_armature[k]),
            "damping": float(model.actuator_damping[k]),
            "is_polynomial": bool(model.actuator_dampingpoly[k].any()),
        }


def _limits(limited: Any, ranges: Any, k: int) -> list[float]:
    if 0 <= k < len(limited) and limited[k]:
        return list(map(float, ranges[k]))
    return []


def _sorted(elements: Any) -> list[Any]:
    return sorted(elements, key=lambda element: element.id)


# -- requests


def answer(text: str, assets: dict[str, bytes]) -> dict[str, Any]:
    """The content of a model, or MuJoCo's error."""
    try:
        return _Compiler(text, assets).answer()
    except MemoryError:
        return {"error": f"needs more than {_MEMORY} bytes of memory to be compiled"}
    except Exception as error:  # noqa: BLE001 - MuJoCo raises errors of any type
        return {"error": str(error) or type(error).__name__}


def serve(source: BinaryIO, target: BinaryIO, patience: int) -> None:
    """Answer requests; an alarm ends the process when it is idle."""
    alarm = limits["IdleAlarm"](patience)
    while True:
        with alarm:
            line = source.readline()
        if not line:
            return
        request = json.loads(line)
        assets: dict[str, bytes] = {}
        for name, size in request["assets"].items():
            assets[name] = source.read(size)
        text = source.read(request["size"]).decode()
        limits["limit_computing"](request["seconds"])
        reply = {**answer(text, assets), "version": f"MuJoCo {mujoco.__version__}"}
        target.write(json.dumps(reply).encode() + b"\n")
        target.flush()


def load_module(name: str) -> Any:
    """Load a module from the folder of this file, by path."""
    place = Path(__file__).with_name(f"{name}.py")
    spec = importlib.util.spec_from_file_location(name, place)
    assert spec is not None and spec.loader is not None  # noqa: S101, PT018
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


limits = runpy.run_path(str(Path(__file__).parents[3] / "ground" / "worker_limits.py"))
start = json.loads(sys.stdin.buffer.readline())
sys.path[:] = start["path"]
import mujoco  # noqa: E402 - found by the parent's path
import numpy  # noqa: E402

geoms = load_module("geoms")
tensors = load_module("tensors")
answer(_FIRST, {})  # loads lazily imported code before the limits apply
answers = os.fdopen(os.dup(1), "wb")
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # discards what MuJoCo prints
limits["close_off"](_MEMORY)
serve(sys.stdin.buffer, answers, start["patience"])
os._exit(0)
