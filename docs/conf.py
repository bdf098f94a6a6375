"""The pages as HTML: `make docs` makes build/docs.

Nothing is fetched, neither then nor by the reader's browser.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs" / "_ext")]


from sphinx.application import Sphinx  # noqa: E402
from sphinx.util.inspect import TypeAliasForwardRef  # noqa: E402

from hybrid_dynamics_core import __version__  # noqa: E402  found by the line above

project = "hybrid_dynamics"
author = "hybrid_dynamics maintainers"
project_copyright = "hybrid_dynamics maintainers, Apache-2.0"
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "formulas",
    "verb_help",
]
exclude_patterns = ["_ext", "images"]

# -- text
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
myst_links_external_new_tab = False
smartquotes = False  # primes of derivatives and options with two dashes stay what they are
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
default_role = "code"  # docstrings mark names with single backticks
nitpicky = True

# -- API
autodoc_member_order = "bysource"
autodoc_mock_imports = ["torch"]  # gigabytes
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_class_signature = "mixed"
add_module_names = False
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 100
ALIASES = ("AnyRobot", "Array", "ArrayLike", "Axes", "Efforts", "Figure", "Names", "Texts")
autodoc_type_aliases = {name: name for name in ALIASES}
nitpick_ignore_regex = [  # of other libraries, and of the inside: nothing is fetched to link them
    ("py:.*", r"(numpy|collections|os|pathlib|matplotlib|typing|enum)\..*"),
    ("py:.*", "|".join(ALIASES)),
    (
        "py:.*",
        r"(.*\.)?(RobotDescription|PoseChain|Program|Prepare|FindFrame|Explain|Call|JointType)",
    ),
    ("py:.*", r"(.*\.)?(Kernel|Link|Transform|(parameters\.changed|other_coordinates)\.R)"),
    (
        "py:.*",
        r"(.*\.)?(Curve|Ramp|Recipe|Row|SingularPlaces|Space|retiming\.curve\.Trajectory)",
    ),
    (
        "py:.*",
        r"(.*\.)?(AppliedWrench|FileOptions|Later|Motion|NoDescriptionError|UnlimitedError|Viewer)",
    ),
    (
        "py:.*",
        r"(.*\.)?(Capable|Driven|Elastic|Lifting|Limited|Retimed)Robot",
    ),
    ("py:.*", r"np\.ndarray"),
]

# -- looks
html_theme = "furo"
pygments_dark_style = "github-dark"
html_title = "hybrid_dynamics"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
copybutton_only_copy_prompt_lines = True


def setup(app: Sphinx) -> None:  # noqa: ARG001
    """Show aliases of types by their names, as `Array | None`."""
    TypeAliasForwardRef.__repr__ = lambda alias: alias.name
