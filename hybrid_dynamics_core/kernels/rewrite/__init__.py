"""Traces with fewer operations, in a better order: equal results but for rounding.

Chains of additions and multiplications become sums of products (`read`). Products and factors that
terms have in common are computed once (`share`), multiplications first. The result is written into
a new graph (`write`). Sums are never multiplied out, so nothing cancels that did not before.
`schedule` orders operations so that few values wait in registers.
"""

from .schedule import scheduled
from .share import share
from .write import rewritten

__all__ = ["rewritten", "scheduled", "share"]
