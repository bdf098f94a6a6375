"""The vocabulary of MJCF: what is read, what is left out with a note, and what may not differ.

https://mujoco.readthedocs.io/en/stable/XMLreference.html. Some attributes may have only the value
that MuJoCo takes anyway. Settings of solver, contacts, pictures and files are left out.
"""

from __future__ import annotations

from ..xml.vocabulary import Vocabulary, vocabulary

ADVICE = "; it may change the robot, so it is not passed over: take it out"
JOINT_NUMBERS = frozenset({"armature", "damping", "frictionloss", "stiffness", "springref"})
DRIVES = "general motor position velocity intvelocity pid damper cylinder muscle"  # of a joint
ORIENTATIONS = frozenset({"quat", "euler", "axisangle", "xyaxes", "zaxis"})
_ORIENTATIONS = " ".join(sorted(ORIENTATIONS))
_SOLVER_SETTINGS = "solref solimp"
_LIMIT_SETTINGS = "solreflimit solimplimit solreffriction solimpfriction margin"
_ENABLED = "enable"
_CONTENT = "site geom body frame"
_OMITTED_CONTENT = "camera light geom"
_CONTROL = (
    "actrange actlimited lengthrange group user"
    " delay interp nsample kp kv ki imax dampratio timeconst inheritrange posrange velrange ffrange"
    " slewmax input area diameter bias range force scale lmin lmax vmax fpmax fvmax dyntype"
    " gaintype biastype dynprm gainprm biasprm actdim actearly tausmooth cranklength"
)
_TRANSMISSIONS = "joint jointinparent tendon site refsite body cranksite slidersite"
_DRIVE_WORDS = f"name class {_TRANSMISSIONS} gear forcerange forcelimited"
_DRIVE = vocabulary(
    _DRIVE_WORDS, omitted=f"ctrlrange ctrllimited {_CONTROL}", armature="0", damping="0"
)
_MOTOR = vocabulary(
    f"{_DRIVE_WORDS} ctrlrange ctrllimited", omitted=_CONTROL, armature="0", damping="0"
)
_TENDON = vocabulary(
    "name class limited",
    "joint site geom pulley",
    omitted="range width material rgba springlength group user actuatorfrclimited actuatorfrcrange"
    f" {_LIMIT_SETTINGS}",
    stiffness="0",
    damping="0",
    frictionloss="0",
    armature="0",
    springyield="0",
)

MJCF: dict[str, Vocabulary] = {
    "mujoco": vocabulary(
        "model",
        "compiler option default worldbody tendon equality actuator keyframe custom",
        omitted="size visual statistic asset contact sensor",
    ),
    "compiler": vocabulary(
        "angle boundmass boundinertia autolimits eulerseq balanceinertia inertiafromgeom"
        " inertiagrouprange",
        omitted="alignfree assetdir meshdir texturedir strippath discardvisual convexhull usethread"
        " fusestatic fitaabb exactmeshinertia conflict passthrough saveinertial savecanonical"
        " savecompiled lengthrange",
        coordinate="local",
        settotalmass="-1",
    ),
    "option": vocabulary(
        "gravity",
        "flag",
        "timestep apirate integrator solver iterations tolerance ls_iterations ls_tolerance"
        " noslip_iterations noslip_tolerance ccd_iterations ccd_tolerance mpr_iterations"
        " mpr_tolerance sdf_iterations sdf_initpoints sleep_tolerance impratio cone jacobian"
        " collision magnetic o_margin o_solref o_solimp o_friction",
        density="0",
        viscosity="0",
        wind="0",
    ),
    "flag": vocabulary(
        omitted="contact clampctrl warmstart filterparent refsafe sensor midphase nativeccd"
        " multiccd island eulerdamp autoreset override energy fwdinv invdiscrete sensornoise sleep"
        " diagexact ipc speculative",
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
    "default": vocabulary(
        "class",
        f"default joint geom site equality tendon {DRIVES}",
        "mesh material texture camera light pair adhesion orientation dcmotor",
    ),
    "default/equality": vocabulary("active", omitted=_SOLVER_SETTINGS),
    "default/tendon": _TENDON,
    "worldbody": vocabulary("childclass", _CONTENT, f"inertial {_OMITTED_CONTENT}"),
    "body": vocabulary(
        f"name pos childclass {_ORIENTATIONS}",
        f"inertial joint freejoint {_CONTENT}",
        f"user sleep fuse simple {_OMITTED_CONTENT}",
        mocap="false",
        gravcomp="0",
    ),
    "frame": vocabulary(
        f"name pos childclass {_ORIENTATIONS}", f"joint freejoint {_CONTENT}", _OMITTED_CONTENT
    ),
    "inertial": vocabulary(f"mass pos diaginertia fullinertia {_ORIENTATIONS}"),
    "geom": vocabulary(  # is left out but for its mass, which the reader says
        "name class type size pos fromto mass density mesh group contype conaffinity condim"
        " priority friction solmix solref solimp margin gap adhesion surfacevel material rgba"
        f" castshadow hfield fitscale fluidshape fluidcoef user {_ORIENTATIONS}",
        shellinertia="false",
    ),
    "site": vocabulary(
        f"name class pos fromto {_ORIENTATIONS}", omitted="type size rgba group material mesh user"
    ),
    "joint": vocabulary(
        f"name class type axis pos range limited ref {' '.join(sorted(JOINT_NUMBERS))}"
        " actuatorfrcrange actuatorfrclimited",
        omitted=f"actuatorgravcomp group user {_LIMIT_SETTINGS}",
        springdamper="0",
        springyield="0",
    ),
    "freejoint": vocabulary("name", omitted="group align"),
    "tendon": vocabulary("", "fixed spatial"),
    "fixed": _TENDON,
    "spatial": _TENDON,
    "fixed/joint": vocabulary("joint coef"),
    "spatial/site": vocabulary("site"),
    "spatial/geom": vocabulary("geom sidesite"),
    "spatial/pulley": vocabulary("divisor"),
    "equality": vocabulary("", "connect weld joint tendon"),
    "equality/tendon": vocabulary(
        "name class active tendon1 tendon2 polycoef", omitted=_SOLVER_SETTINGS
    ),
    "connect": vocabulary(
        "name class active body1 body2 anchor site1 site2", omitted=_SOLVER_SETTINGS
    ),
    "weld": vocabulary(
        "name class active body1 body2 anchor relpose site1 site2",
        omitted=f"torquescale {_SOLVER_SETTINGS}",
    ),
    "equality/joint": vocabulary(
        "name class active joint1 joint2 polycoef", omitted=_SOLVER_SETTINGS
    ),
    "actuator": vocabulary("", DRIVES),
    **dict.fromkeys(DRIVES.split(), _DRIVE),
    "motor": _MOTOR,
    "keyframe": vocabulary("", "key"),
    "key": vocabulary("name qpos", omitted="time qvel act ctrl mpos mquat plastic"),
    "custom": vocabulary("", "text", "numeric tuple"),
}
