"""An excavator lifts and slews its load as fast as its pump allows.

python examples/as_fast_as_the_pump_allows.py [--plot FILE]

One pump feeds boom, stick and bucket. The path goes from the ground to the truck.
`robot.retime` passes it in the shortest time within pressures, flow and power of the pump, and
torque and rate of the slewing gear. A larger flow helps only while power is free.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from hybrid_dynamics_core import Payload, Robot, load
from hybrid_dynamics_core.description.actuators import Pump
from hybrid_dynamics_core.retiming import TimedMotion

LITRES = 6e4  # [l/min] in a m^3/s
LOAD = Payload(900.0, com=(-0.6, 0.3, 0.0))  # in the bucket [kg], [m]
CYLINDERS = ("boom_cylinder", "stick_cylinder", "bucket_cylinder")
PATH = np.array([[0.0, 0.3, 0.8, 0.85], [0.5, 0.6, 0.7, 0.85], [1.2, 0.8, 0.6, 0.8]])  # [rad], [m]
FLOWS = np.array([80.0, 120.0, 180.0, 260.0])  # of the pump [l/min]
POWER = 40e3  # [W]
SHOWN = 120.0  # flow of the motion that is drawn [l/min]


def with_pump(flow: float) -> Robot:
    """The excavator with a pump of a flow [l/min] and a slewing gear."""
    description = load("excavator").description
    slew = replace(description.joints["slew"], effort_limit=120e3, velocity_limit=1.1)
    pump = Pump(CYLINDERS, flow_limit=flow / LITRES, power_limit=POWER)
    joints = {**description.joints, "slew": slew}
    return Robot(replace(description, joints=joints, pumps={"main": pump}))


def fastest(flow: float, stations: int = 60) -> tuple[Robot, TimedMotion]:
    """The machine with a pump of a flow [l/min], and its fastest motion."""
    machine = with_pump(flow)
    loads = machine.loads.with_payload(LOAD)
    return machine, machine.retime(PATH, loads, stations=stations)


def history(machine: Robot, motion: TimedMotion) -> dict[str, np.ndarray]:
    """Times [s], flow of the pump [l/min] and its power [kW] during a motion."""
    t = np.linspace(0.0, motion.duration, 600)
    u, du, ddu = motion(t)
    loads = machine.loads.with_payload(LOAD)
    margins = machine.limit_margins(machine.close(u, du), ddu, loads=loads)
    kinds = [row.kind for row in margins.rows]
    flow = margins.values[:, kinds.index("pump_flow")]
    power = margins.values[:, kinds.index("pump_power")]
    return {"t": t, "flow": LITRES * flow, "power": power / 1e3}


def plot(durations: np.ndarray, shown: dict[str, np.ndarray], path: str) -> None:
    """Flow and power of the pump over time, and the duration over the flow of the pump."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415

    title = "An excavator as fast as its pump allows"
    about = f"{LOAD.mass:.0f} kg from the ground to a truck, pump of {POWER / 1e3:.0f} kW"
    with written_page(path, title, about, height=3.4) as figure:
        use, times = figure.subplots(1, 2)
        use.plot(shown["t"], shown["flow"] / SHOWN, label="flow")
        use.plot(shown["t"], 1e3 * shown["power"] / POWER, label="power")
        use.set(xlabel="time [s]", ylabel="share of the pump's limit [-]", ylim=(0.0, 1.15))
        times.plot(FLOWS, durations, "o-", label="shortest time")
        times.set(xlabel="flow of the pump [l/min]", ylabel="duration [s]", ylim=(0.0, None))
        entitled(use, f"a pump of {SHOWN:.0f} l/min", 2)
        entitled(times, "other pumps of the same power", 1)


def main() -> None:
    """Print durations with several pumps; draw if asked."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--plot", metavar="FILE", help="draw to this file")
    arguments = parser.parse_args()
    durations = []
    shown = {}
    for flow in FLOWS:
        machine, motion = fastest(float(flow))
        durations.append(motion.duration)
        limits = [f"{kind.replace('_', ' ')} of {name}" for name, kind in motion.limited_by]
        what = ", ".join(limits)
        print(f"a pump of {flow:.0f} l/min: {motion.duration:.2f} s, limited by {what}")
        if flow == SHOWN:
            shown = history(machine, motion)
    if arguments.plot:
        plot(np.array(durations), shown, arguments.plot)


if __name__ == "__main__":
    main()
