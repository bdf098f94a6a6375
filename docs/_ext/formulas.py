"""Formulas as drawings within the page, made by ziamath while it is built.

The reader's browser fetches nothing for them: no script, no fonts.
"""

from __future__ import annotations

import re
from html import escape

import ziamath
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.math import get_node_equation_number
from sphinx.writers.html5 import HTML5Translator

SIZE = 18.0  # of the font in the drawing; on the page it is that of the text around
BOX = re.compile(r'viewBox="([^"]+)"')
ziamath.config.svg2 = False  # glyphs as paths: all drawings of a page would share their names


def drawn(tex: str, *, within_a_line: bool) -> str:
    """A formula as an SVG element in the text's colour, in units of its font's size.

    Its TeX is the label that is read aloud.
    """
    svg = str(ziamath.Latex(tex, size=SIZE, color="currentColor", inline=within_a_line).svg())
    _, top, width, height = (float(side) / SIZE for side in BOX.findall(svg)[0].split())
    baseline = -top - height
    style = f"width:{width:.3f}em;height:{height:.3f}em;vertical-align:{baseline:.3f}em"
    attributes = f'class="formula" role="img" aria-label="{escape(tex)}" style="{style}"'
    return svg.replace("<svg ", f"<svg {attributes} ", 1)


def inline(self: HTML5Translator, node: nodes.math) -> None:
    """Put a formula into a line."""
    self.body.append(drawn(node.astext(), within_a_line=True))
    raise nodes.SkipNode


def displayed(self: HTML5Translator, node: nodes.math_block) -> None:
    """Put a formula into lines of its own, with its number where it has one."""
    self.body.append(self.starttag(node, "div", CLASS="formula"))
    self.body.append(f'<div class="drawn">{drawn(node.astext(), within_a_line=False)}</div>')
    if node.get("number"):
        self.body.append(f'<span class="eqno">({get_node_equation_number(self, node)})')
        self.add_permalink_ref(node, "Link to this equation")
        self.body.append("</span>")
    self.body.append("</div>")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer."""
    app.add_html_math_renderer("drawn", (inline, None), (displayed, None))
    app.config.html_math_renderer = "drawn"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
