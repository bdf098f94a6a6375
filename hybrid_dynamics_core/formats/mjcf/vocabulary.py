"""The vocabulary of MJCF: words that are used, and words left out with a note.

https://mujoco.readthedocs.io/en/stable/XMLreference.html. MuJoCo
interprets the words, this table selects those that are used. Settings of solver, contacts, pictures
and files are left out. A word that is not listed, as of a newer MuJoCo, is refused.
"""

from __future__ import annotations

from ..xml.vocabulary import Vocabulary, vocabulary

# solver settings that only MuJoCo uses, written by `writer`
FOR_MUJOCO = frozenset(
    {
        "option.timestep",
        "option.integrator",
        "flag.contact",
        "connect.solref",
        "connect.solimp",
        "key.ctrl",
    }
)
ADVICE = "; it may change the robot, so it is not passed over: take it out"
DRIVES = "general motor position velocity intvelocity pid damper cylinder muscle dcmotor plugin"
_ORIENTATIONS = "quat euler axisangle xyaxes zaxis"
_SOLVER_SETTINGS = "solref solimp"
_LIMIT_SETTINGS = "solreflimit solimplimit solreffriction solimpfriction margin"
_CONTENT = "site geom body frame replicate attach"
_DEFAULT_DRIVES = DRIVES.removesuffix(" plugin")
_OMITTED_CONTENT = "camera light"
_CONTROL = (
    "actrange actlimited lengthrange group user"
    " delay interp nsample kp kv ki imax dampratio timeconst inheritrange posrange velrange ffrange"
    " slewmax input area diameter bias range force scale lmin lmax vmax fpmax fvmax dyntype"
    " gaintype biastype dynprm gainprm biasprm actdim actearly tausmooth cranklength"
)
_TRANSMISSIONS = "joint jointinparent tendon site refsite body cranksite slidersite"
_DRIVE_WORDS = f"name class {_TRANSMISSIONS} gear forcerange forcelimited"
_DRIVE = vocabulary(f"{_DRIVE_WORDS} armature damping", omitted=f"ctrlrange ctrllimited {_CONTROL}")
_MOTOR = vocabulary(f"{_DRIVE_WORDS} armature damping ctrlrange ctrllimited", omitted=_CONTROL)
_TENDON = vocabulary(
    "name class limited stiffness damping frictionloss armature springlength springyield",
    "joint site geom pulley",
    omitted="range width material rgba group user actuatorfrclimited actuatorfrcrange"
    f" {_LIMIT_SETTINGS}",
)

MJCF: dict[str, Vocabulary] = {
    "mujoco": vocabulary(
        "model",
        "compiler option default worldbody asset tendon equality actuator keyframe custom"
        " deformable",
        omitted="size visual statistic contact sensor extension",
    ),
    "asset": vocabulary("", "mesh material model", "texture hfield skin"),
    "compiler": vocabulary(
        "angle boundmass boundinertia autolimits eulerseq balanceinertia inertiafromgeom"
        " inertiagrouprange settotalmass alignfree",
        omitted="assetdir meshdir texturedir strippath discardvisual convexhull usethread"
        " fusestatic fitaabb exactmeshinertia conflict passthrough saveinertial savecanonical"
        " savecompiled lengthrange",
        coordinate="local",
    ),
    "option": vocabulary(
        "gravity density viscosity actuatorgroupdisable",
        "flag",
        "timestep apirate integrator solver iterations tolerance ls_iterations ls_tolerance"
        " noslip_iterations noslip_tolerance ccd_iterations ccd_tolerance mpr_iterations"
        " mpr_tolerance sdf_iterations sdf_initpoints sleep_tolerance impratio cone jacobian"
        " collision magnetic o_margin o_solref o_solimp o_friction wind",
    ),
    "flag": vocabulary(
        "constraint equality frictionloss limit passive spring damper gravity actuation",
        omitted="contact clampctrl warmstart filterparent refsafe sensor midphase nativeccd"
        " multiccd island eulerdamp autoreset override energy fwdinv invdiscrete sensornoise sleep"
        " diagexact ipc speculative",
    ),
    "default": vocabulary(
        "class",
        f"default joint geom site equality tendon {_DEFAULT_DRIVES}",
        "mesh material texture camera light pair adhesion orientation",
    ),
    "default/equality": vocabulary("active", omitted=_SOLVER_SETTINGS),
    "default/tendon": _TENDON,
    "worldbody": vocabulary("childclass", _CONTENT, f"inertial {_OMITTED_CONTENT}"),
    "body": vocabulary(
        f"name pos childclass mocap gravcomp {_ORIENTATIONS}",
        f"inertial joint freejoint {_CONTENT}",
        f"user sleep fuse simple {_OMITTED_CONTENT}",
    ),
    "frame": vocabulary(
        f"name pos childclass {_ORIENTATIONS}", f"joint freejoint {_CONTENT}", _OMITTED_CONTENT
    ),
    "replicate": vocabulary(
        "count euler offset sep prefix childclass", f"joint freejoint {_CONTENT}", _OMITTED_CONTENT
    ),
    "attach": vocabulary("model body frame prefix"),
    "inertial": vocabulary(f"mass pos diaginertia fullinertia {_ORIENTATIONS}"),
    "geom": vocabulary(  # gives mass and visuals; contacts are left out, as the reader says
        "name class type size pos fromto mass density mesh group contype conaffinity condim"
        " priority friction solmix solref solimp margin gap adhesion surfacevel material rgba"
        f" castshadow hfield fitscale fluidshape fluidcoef user shellinertia {_ORIENTATIONS}",
        omitted="plugin",
    ),
    "site": vocabulary(
        f"name class pos fromto {_ORIENTATIONS}", omitted="type size rgba group material mesh user"
    ),
    "joint": vocabulary(
        "name class type axis pos range limited ref armature damping frictionloss stiffness"
        " springref springdamper springyield actuatorfrcrange actuatorfrclimited",
        omitted=f"actuatorgravcomp group user {_LIMIT_SETTINGS}",
    ),
    "freejoint": vocabulary("name align", omitted="group"),
    "tendon": vocabulary("", "fixed spatial"),
    "fixed": _TENDON,
    "spatial": _TENDON,
    "fixed/joint": vocabulary("joint coef"),
    "spatial/site": vocabulary("site"),
    "spatial/geom": vocabulary("geom sidesite"),
    "spatial/pulley": vocabulary("divisor"),
    "equality": vocabulary("", "connect weld joint tendon", "flex flexvert flexstrain"),
    "deformable": vocabulary("", "", "skin"),
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
    "actuator": vocabulary("", DRIVES, "adhesion orientation"),
    **dict.fromkeys(DRIVES.split(), _DRIVE),
    "motor": _MOTOR,
    "general": _MOTOR,
    "dcmotor": vocabulary(
        f"{_DRIVE_WORDS} armature damping",
        omitted=f"cogging controller ctrlrange ctrllimited inductance lugre motorconst nominal"
        f" resistance saturation thermal {_CONTROL}",
    ),
    "plugin": vocabulary(
        f"{_DRIVE_WORDS} armature damping",
        omitted=f"plugin instance ctrlrange ctrllimited config {_CONTROL}",
    ),
    "keyframe": vocabulary("", "key"),
    "key": vocabulary("name qpos", omitted="time qvel act ctrl mpos mquat plastic"),
    "custom": vocabulary("", "text", "numeric tuple"),
}

_WITHOUT_MEANING = "size visual statistic contact sensor custom extension deformable"
_PICTURES = "texture skin hfield"
_OF_MATERIALS = (
    "texture emission specular shininess reflectance metallic roughness texrepeat texuniform"
)
_NO_DEFAULTS = "texture material camera light pair adhesion orientation"
_FILES = "assetdir meshdir texturedir strippath discardvisual fusestatic"

# Elements removed from MuJoCo's input, by parent element; "" for any:
OMITTED: dict[str, frozenset[str]] = {
    "mujoco": frozenset(_WITHOUT_MEANING.split()),
    "asset": frozenset(_PICTURES.split()),
    "material": frozenset({"layer"}),
    "default": frozenset(_NO_DEFAULTS.split()),
    "actuator": frozenset({"adhesion", "orientation"}),
    "equality": frozenset({"flex", "flexvert", "flexstrain"}),
    "compiler": frozenset({"lengthrange"}),
    "": frozenset({"camera", "light", "plugin", "config"}),
}
# Its attributes, by its tag; "" for any other:
OMITTED_ATTRIBUTES: dict[str, frozenset[str]] = {
    "geom": frozenset(),
    "material": frozenset(_OF_MATERIALS.split()),
    "compiler": frozenset(_FILES.split()),
    "key": frozenset({"time", "qvel", "act", "ctrl", "mpos", "mquat", "plastic"}),
    "plugin": frozenset({"plugin", "instance", *_CONTROL.split()}),
    "": frozenset({"material"}),
}
