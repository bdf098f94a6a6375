"""The vocabulary of MJCF: what is read, and what changes no robot.

https://mujoco.readthedocs.io/en/stable/XMLreference.html. Some attributes may have only the value
that MuJoCo takes anyway. Settings of solver, contacts, pictures and files are free.
"""

from __future__ import annotations

from ..xml.vocabulary import Vocabulary, vocabulary

ADVICE = (
    "; of MJCF what this library writes is read, bodies with their inertia on hinges and slides"
)
JOINT_NUMBERS = frozenset({"armature", "damping", "frictionloss", "stiffness", "springref"})
_ORIENTATIONS = "quat euler axisangle xyaxes zaxis"
_EFFORT_RANGE = "actuatorfrcrange actuatorfrclimited"
_SOLVER_SETTINGS = "solref solimp"
_ENABLED = "enable"

MJCF: dict[str, Vocabulary] = {
    "mujoco": vocabulary(
        "model",
        "compiler option worldbody equality actuator tendon keyframe custom size visual statistic"
        " asset",
    ),
    "compiler": vocabulary(
        "angle boundmass boundinertia autolimits alignfree assetdir meshdir texturedir strippath"
        " discardvisual convexhull usethread fusestatic eulerseq fitaabb inertiagrouprange"
        " exactmeshinertia conflict saveinertial savecanonical savecompiled",
        "lengthrange",
        balanceinertia="false",
        coordinate="local",
        inertiafromgeom="auto|false",  # shapes have no mass here
        settotalmass="-1",
    ),
    "option": vocabulary(
        "gravity timestep apirate integrator solver iterations tolerance ls_iterations ls_tolerance"
        " noslip_iterations noslip_tolerance ccd_iterations ccd_tolerance mpr_iterations"
        " mpr_tolerance sdf_iterations sdf_initpoints sleep_tolerance impratio cone jacobian"
        " collision magnetic o_margin o_solref o_solimp o_friction",
        "flag",
        density="0",
        viscosity="0",
        wind="0",
    ),
    "flag": vocabulary(
        "contact clampctrl warmstart filterparent refsafe sensor midphase nativeccd multiccd island"
        " eulerdamp autoreset override energy fwdinv invdiscrete sensornoise sleep diagexact",
        constraint=_ENABLED,
        equality=_ENABLED,
        frictionloss=_ENABLED,
        limit=_ENABLED,
        passive=_ENABLED,
        spring=_ENABLED,
        damper=_ENABLED,
        gravity=_ENABLED,
        actuation=_ENABLED,
    ),
    "worldbody": vocabulary("", "inertial joint site geom body light camera"),
    "body": vocabulary(
        f"name pos user {_ORIENTATIONS}",
        "inertial joint site geom body light camera",
        mocap="false",
        gravcomp="0",
    ),
    "inertial": vocabulary(f"mass pos diaginertia fullinertia {_ORIENTATIONS}"),
    "site": vocabulary(f"name pos type size rgba group material user {_ORIENTATIONS}"),
    "joint": vocabulary(
        f"name type axis range limited {_EFFORT_RANGE} {' '.join(sorted(JOINT_NUMBERS))}"
    ),
    "equality": vocabulary("", None),
    "connect": vocabulary(f"name site1 site2 {_SOLVER_SETTINGS}", active="true"),
    "weld": vocabulary(f"name site1 site2 {_SOLVER_SETTINGS}", active="true"),
    "equality/joint": vocabulary(f"name joint1 joint2 polycoef {_SOLVER_SETTINGS}", active="true"),
    "equality/tendon": vocabulary(f"name tendon1 polycoef {_SOLVER_SETTINGS}", active="true"),
    "tendon": vocabulary("", "fixed"),
    "fixed": vocabulary("name", "joint"),
    "fixed/joint": vocabulary("joint coef"),
    "actuator": vocabulary("", None),
    "motor": vocabulary(
        "name joint group user ctrlrange ctrllimited forcerange forcelimited", gear="1"
    ),
}
