"""Motors of a catalogue in a duty cycle: peak and rms torque, speed and power at their shaft."""

from __future__ import annotations

import math

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array
from .catalogue import CatalogueMotor
from .checks import Candidate, Check, Margins
from .demand import Demand, largest, root_mean_square


def motor_checks(row: CatalogueMotor, demand: Demand, margins: Margins) -> Candidate:
    """What a motor of a catalogue would give, its own inertia included.

    Raises:
        InputError: the joint slides, and the catalogue has no lead of a screw.
    """
    ratio = shaft_ratio(row, demand)
    torque = shaft_torque(row, demand, ratio)
    speed = ratio * demand.rate
    peak = row.peak_torque
    if math.isnan(peak):
        peak = row.torque
    rms = root_mean_square(torque, demand.weights)
    checks = [
        Check("peak torque", margins.torque * largest(torque), peak, "N m"),
        Check("rms torque", margins.rms * rms, row.torque, "N m"),
        Check("speed", margins.speed * largest(speed), row.speed, "rad/s"),
    ]
    if not math.isnan(row.power):
        power = torque * speed
        needed = margins.power * largest(power)
        checks.append(Check("power", needed, row.power, "W"))
    return Candidate(row.name, tuple(checks))


def shaft_ratio(row: CatalogueMotor, demand: Demand) -> float:
    """Rate of the shaft for a rate of the joint [1, or rad/m].

    Raises:
        InputError: the joint slides, and the catalogue has no lead of a screw.
    """
    if demand.kind == "revolute":
        return row.gear_ratio
    if math.isnan(row.lead):
        raise InputError(
            f"{row.name}: {demand.drive} slides, so a motor needs a column lead of its screw"
        )
    return row.gear_ratio * 2.0 * math.pi / row.lead


def shaft_torque(row: CatalogueMotor, demand: Demand, ratio: float) -> Array:
    """Torque at the shaft (N,) [N m].

    Gear and screw lose power: the motor gives more where it drives, and brakes less where the load
    drives it.
    """
    torque = demand.force / ratio
    power = demand.force * demand.rate
    drives = power > 0.0
    brakes = power < 0.0
    torque[drives] /= row.efficiency
    torque[brakes] *= row.efficiency
    rotor = row.inertia * ratio
    return np.asarray(torque + rotor * demand.acceleration)
