"""A picture of a simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

if TYPE_CHECKING:
    from .result import Simulation


def plot_simulation(simulation: Simulation) -> Figure:
    """Four panels over time: coordinates, rates, efforts, energy."""
    figure = Figure(figsize=(9.0, 9.0), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True)
    panels = (("u [rad, m]", simulation.u), ("u' [rad/s, m/s]", simulation.du), ("tau [N m, N]", simulation.tau))
    for ax, (label, values) in zip(axes, panels, strict=False):
        for name, column in zip(simulation.names, values.T, strict=True):
            ax.plot(simulation.t, column, label=name)
        ax.set_ylabel(label)
    axes[0].legend(ncols=min(len(simulation.names), 6), fontsize="small")
    energy = simulation.energy
    for label, part in (("kinetic", energy.kinetic), ("potential", energy.potential - energy.potential[0])):
        axes[3].plot(simulation.t, part, label=label)
    if energy.springs.any():
        axes[3].plot(simulation.t, energy.springs, label="springs")
    axes[3].plot(simulation.t, simulation.work, "--", label="work in")
    axes[3].set_ylabel("energy [J]")
    axes[3].legend(ncols=4, fontsize="small")
    axes[3].set_xlabel("t [s]")
    for ax in axes:
        for event in simulation.events:
            ax.axvline(event.time, color="0.5", linewidth=0.8)
        ax.grid(alpha=0.3)
    figure.suptitle(f"{simulation.robot}: {simulation.message}", fontsize="medium")
    return figure
