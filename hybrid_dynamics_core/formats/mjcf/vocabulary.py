"""The words of MJCF: what is read, what changes no robot, and what may have the value only that MuJoCo takes anyway.

https://mujoco.readthedocs.io/en/stable/XMLreference.html. Settings of solver, contacts, pictures
and files are free.
"""

from __future__ import annotations

from ..xml.vocabulary import Words, words

ONLY = "; of MJCF what this library writes is read, bodies with their inertia on hinges and slides"
NUMBERS = frozenset({"armature", "damping", "frictionloss", "stiffness", "springref"})
TURNS = "quat euler axisangle xyaxes zaxis"
SOFT = "solref solimp"
ON = "enable"

MJCF: dict[str, Words] = {
    "mujoco": words(
        "model",
        "compiler option worldbody equality actuator keyframe custom size visual statistic asset",
    ),
    "compiler": words(
        "angle boundmass boundinertia autolimits alignfree assetdir meshdir texturedir strippath"
        " discardvisual convexhull usethread fusestatic eulerseq fitaabb inertiagrouprange"
        " exactmeshinertia conflict saveinertial savecanonical savecompiled",
        "lengthrange",
        balanceinertia="false",
        coordinate="local",
        inertiafromgeom="auto|false",  # shapes have no mass here
        settotalmass="-1",
    ),
    "option": words(
        "gravity timestep apirate integrator solver iterations tolerance ls_iterations ls_tolerance"
        " noslip_iterations noslip_tolerance ccd_iterations ccd_tolerance mpr_iterations"
        " mpr_tolerance sdf_iterations sdf_initpoints sleep_tolerance impratio cone jacobian"
        " collision magnetic o_margin o_solref o_solimp o_friction",
        "flag",
        density="0",
        viscosity="0",
        wind="0",
    ),
    "flag": words(
        "contact clampctrl warmstart filterparent refsafe sensor midphase nativeccd multiccd island"
        " eulerdamp autoreset override energy fwdinv invdiscrete sensornoise sleep diagexact",
        constraint=ON,
        equality=ON,
        frictionloss=ON,
        limit=ON,
        passive=ON,
        spring=ON,
        damper=ON,
        gravity=ON,
        actuation=ON,
    ),
    "worldbody": words("", "inertial joint site geom body light camera"),
    "body": words(
        f"name pos user {TURNS}",
        "inertial joint site geom body light camera",
        mocap="false",
        gravcomp="0",
    ),
    "inertial": words(f"mass pos diaginertia fullinertia {TURNS}"),
    "site": words(f"name pos type size rgba group material user {TURNS}"),
    "joint": words(f"name type axis range limited {' '.join(sorted(NUMBERS))}"),
    "equality": words("", None),
    "connect": words(f"name site1 site2 {SOFT}", active="true"),
    "weld": words(f"name site1 site2 {SOFT}", active="true"),
    "equality/joint": words(f"name joint1 joint2 polycoef {SOFT}", active="true"),
    "actuator": words("", None),
    "motor": words("name joint group user ctrlrange ctrllimited forcerange forcelimited", gear="1"),
}
