"""Names of joints and loops as a legend shows them."""

from __future__ import annotations


def legend_text(name: str) -> str:
    """A name for a legend, since Matplotlib omits labels that begin with an underscore."""
    if name.startswith("_"):
        return f" {name}"
    return name
