"""Formulas as MathML, which browsers draw themselves: nothing to fetch, no script, and they can be read aloud."""

from __future__ import annotations

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.errors import SphinxError
from sphinx.util.math import get_node_equation_number
from sphinx.writers.html5 import HTML5Translator


def converted(self: HTML5Translator, node: nodes.math | nodes.math_block, *, block: bool) -> str:
    """The formula of a node. A formula that cannot be shown ends the build."""
    try:
        return str(tex2mathml(node.astext(), as_block=block))
    except MathError as error:
        raise SphinxError(f"{node.source}:{node.line}: formula {node.astext()!r}: {error}") from error


def inline(self: HTML5Translator, node: nodes.math) -> None:
    """Put a formula into a line."""
    self.body.append(converted(self, node, block=False))
    raise nodes.SkipNode


def displayed(self: HTML5Translator, node: nodes.math_block) -> None:
    """Put a formula into lines of its own, with its number where it has one."""
    self.body.append(self.starttag(node, "div", CLASS="formula"))
    self.body.append(converted(self, node, block=True))
    if node.get("number"):
        self.body.append(f'<span class="eqno">({get_node_equation_number(self, node)})')
        self.add_permalink_ref(node, "Link to this equation")
        self.body.append("</span>")
    self.body.append("</div>")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (inline, None), (displayed, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
