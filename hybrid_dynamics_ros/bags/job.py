"""Jobs of processing a bag, and their outcomes."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from ..parameters import NodeSettings

CAUSAL: Final = "causal"  # the node's filter
SMOOTHINGS: Final = (CAUSAL, "savgol", "spline")


@dataclass(frozen=True)
class Job:
    """A job: the processing of one bag.

    Attributes:
        source: the bag to read.
        target: the bag to write.
        robot: name of a shipped robot, or path of a description file.
        topic: topic of joint states or motions; None: see `input_topic`.
        smooth: estimator of rates, one of `SMOOTHINGS`.
        keep: whether original topics are copied to the new bag.
        settings: parameters of the node.
    """

    source: Path
    target: Path
    robot: str
    topic: str | None = None
    smooth: str = CAUSAL
    keep: bool = False
    settings: NodeSettings = field(default_factory=NodeSettings)


@dataclass(eq=False)
class Outcome:
    """The outcome of a job.

    Attributes:
        job: the job.
        summary: one line about the samples.
        losses: texts of `Losses.describe` on parts that could not be read.
        rejections: first text of each kind of rejection.
        outliers: texts on samples without acceleration, which `smooth` left out.
        bulk: share of samples decoded in bulk.
        shares: time of each step [s]: reading, decoding, model, encoding, writing.
        beside: time of the parallel thread that compresses and writes chunks [s].
        duration: time between first and last stamp [s].
        samples: number of samples.
    """

    job: Job
    summary: str = ""
    losses: list[str] = field(default_factory=list)
    rejections: dict[str, str] = field(default_factory=dict)
    outliers: list[str] = field(default_factory=list)
    bulk: float = 0.0
    shares: Counter[str] = field(default_factory=Counter)
    beside: float = 0.0
    duration: float = 0.0
    samples: int = 0
