"""The figure of a report with recorded pressures beside those that the model needs."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from hybrid_dynamics_core.errors import SingularityError
from hybrid_dynamics_core.scene.style import QUIET

from ...messages.joint_samples import FloatArray
from .plotting import LEGEND_ABOVE, clip_outliers, colour_of, draw_line, make_panels
from .recording import EvaluatedRecording

_BAR: Final = 1e5  # [Pa]
_CAP: Final = "#b4bac2"
_ROD: Final = "#e6bcbc"


def pressures(recording: EvaluatedRecording) -> Figure:
    """Recorded and required pressures of each cylinder, and their difference on the cap side."""
    required = required_pressures(recording)
    figure, axes = make_panels(len(required), 2, 1.9)
    for k, (name, needed) in enumerate(required.items()):
        recorded = recording.pressures[name] / _BAR
        cap, rod = recorded.T
        pressure_ax, difference_ax = axes[k]
        draw_line(pressure_ax, recording, rod, _ROD, label="rod side, recorded", linewidth=1.8)
        draw_line(pressure_ax, recording, cap, _CAP, label="cap side, recorded", linewidth=1.8)
        draw_line(pressure_ax, recording, needed / _BAR, colour_of(k), label="cap side, required")
        clip_outliers(pressure_ax, recording, cap, rod)
        difference = cap - needed / _BAR
        draw_line(difference_ax, recording, difference, colour_of(k))
        clip_outliers(difference_ax, recording, difference)
        difference_ax.axhline(0.0, color=QUIET, linewidth=0.6)
        for ax in (pressure_ax, difference_ax):
            ax.set_ylabel(f"{name} [bar]")
    axes[0][0].legend(**LEGEND_ABOVE, ncols=3)
    axes[0][1].set_title("cap side, recorded less required")
    return figure


def required_pressures(recording: EvaluatedRecording) -> dict[str, FloatArray]:
    """Pressures (N,) on the cap side that the computed forces need, by cylinder [Pa].

    The rod side has its recorded pressure. They are NaN where the efforts or pressures are unknown.
    """
    count = len(recording.time)
    forces = {name: np.full(count, np.nan) for name in recording.pressures}
    rows = np.flatnonzero(np.isfinite(recording.efforts).all(axis=1))
    if len(rows):
        state = recording.state.rows(rows)
        try:
            along = recording.robot.drive_forces(state, recording.efforts[rows])
        except SingularityError:
            along = {}  # the drives cannot give these efforts
        for name, force in forces.items():
            if name in along:
                force[rows] = along[name]
    required: dict[str, FloatArray] = {}
    for name, force in forces.items():
        cylinder = recording.robot.cylinders[name]
        rod = recording.pressures[name][:, 1]
        push = cylinder.sign * force
        required[name] = (push + rod * cylinder.rod_area) / cylinder.cap_area
    return required
