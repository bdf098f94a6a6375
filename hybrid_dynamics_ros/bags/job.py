"""What is to be done with a bag, and what came of it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from ..parameters import NodeSettings

CAUSAL: Final = "causal"  # the node's filter, sample by sample
SMOOTHINGS: Final = (CAUSAL, "savgol", "spline")


@dataclass(frozen=True)
class Job:
    """What is to be done with one bag.

    Attributes:
        source: the bag that is read.
        target: the bag that is written.
        robot: name of a shipped robot, or path of a description file.
        topic: where the joint states or motions are; None: see `input_topic`.
        smooth: how rates are found, one of `SMOOTHINGS`.
        keep: whether the original topics go into the new bag too.
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
    """What came of a job.

    Attributes:
        job: the job.
        summary: one line about the samples.
        losses: what could not be read, as `Losses.describe` says it.
        rejections: the first text of each kind of rejection.
        outliers: samples that `smooth` made no accelerations of, a text each.
        bulk: share of the samples that were decoded in bulk.
        shares: time spent on each step [s]: reading, decoding, the model, encoding, and writing.
        beside: time that the thread took which makes and writes chunks meanwhile [s].
        duration: of the samples' stamps [s].
        samples: how many samples there were.
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
