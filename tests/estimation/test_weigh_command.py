"""`hybrid-dynamics weigh`: units of columns, bags, and what no sensor can have measured."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from benchmarks.estimation.lifts import machine, recorded
from hybrid_dynamics_core.export import to_yaml
from tests.cli.calling import call, data_of
from tests.sampling import swept

MASS = 1234.0
BOOM = "boom_cylinder.cap_pressure"


def columns_of(recording):
    columns = {"time": recording.time.copy(), **recording.positions}
    for name, (cap, rod) in recording.pressures.items():
        columns |= {f"{name}.cap_pressure": cap, f"{name}.rod_pressure": rod}
    return columns


def write(path, columns):
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    return str(path)


@pytest.fixture(scope="module")
def lifted(tmp_path_factory):
    """The folder with a robot and its empty run, and the columns of a lift."""
    folder = tmp_path_factory.mktemp("weigh")
    rng = np.random.default_rng(3)
    both = machine(rng)
    (folder / "robot.yaml").write_text(to_yaml(both.model), encoding="utf-8")
    write(folder / "empty.csv", columns_of(recorded(both.true, rng, 0.0)))
    return folder, columns_of(recorded(both.true, rng, MASS))


def weigh(folder, data, *options):
    return call("weigh", data, "--robot", str(folder / "robot.yaml"), *options)


def test_a_lift_is_weighed_in_any_units(lifted):
    folder, columns = lifted
    robot = ("--robot", str(folder / "robot.yaml"))
    plain = data_of("weigh", write(folder / "lift.csv", columns), *robot)
    assert plain["interval"][0] < MASS < plain["interval"][1]
    others = {}
    for name, values in columns.items():
        if "pressure" in name:
            others[f"{name} [bar]"] = values * 1e-5
        elif "cylinder" in name:
            others[f"{name} [mm]"] = values * 1e3
        else:
            others[name] = values
    data = write(folder / "lift_bar.csv", others)
    assert data_of("weigh", data, *robot)["mass"] == pytest.approx(plain["mass"], abs=1e-3)
    empty = ("--empty", str(folder / "empty.csv"))
    zeroed = data_of("weigh", data, *robot, *empty)
    low, high = zeroed["interval"]
    assert low < MASS < high
    assert high - low < 20.0
    assert zeroed["quality"] == "good"
    text = weigh(folder, data, *empty).stdout
    assert "quality  good (with the empty run)" in text


def stuck(columns, name):
    values = columns[name].copy()
    values[200:] = values[200]
    return columns | {name: values}


def exchanged(columns, cylinder):
    cap, rod = f"{cylinder}.cap_pressure", f"{cylinder}.rod_pressure"
    return columns | {cap: columns[rod], rod: columns[cap]}


def jumped(columns, seconds):
    time = columns["time"].copy()
    time[300:] += seconds
    return columns | {"time": time}


def in_bar(columns, names):
    return columns | {name: columns[name] * 1e-5 for name in columns if name.startswith(names)}


MISTAKES = {
    "all in bar": (
        lambda c: in_bar(c, ("boom_cylinder.", "stick_cylinder.", "bucket_cylinder.")),
        "seem to be in",
    ),
    "one in bar": (lambda c: in_bar(c, ("bucket_cylinder.",)), "bucket_cylinder.*in bar"),
    "Pa times 1e5": (lambda c: c | {BOOM: c[BOOM] * 1e5}, "and its supply has 3.5e"),
    "exchanged boom": (lambda c: exchanged(c, "boom_cylinder"), "boom_cylinder.*exchanged"),
    "exchanged bucket": (lambda c: exchanged(c, "bucket_cylinder"), "bucket_cylinder.*exchanged"),
    "stuck pressure": (lambda c: stuck(c, BOOM), f"{BOOM} is .* stuck"),
    "stuck stroke": (lambda c: stuck(c, "stick_cylinder"), "stick_cylinder is .* stuck"),
    "clock ahead": (lambda c: jumped(c, 3.0), "clock jumps by 3.02 s at sample 300"),
    "clock back": (lambda c: jumped(c, -3.0), "clock goes from 5.98 s to 3 s"),
    "one side": (
        lambda c: {k: v for k, v in c.items() if k != BOOM},
        f"no column {BOOM}",
    ),
    "misspelt": (
        lambda c: {k.replace("boom_c", "bom_c"): v for k, v in c.items() if k != "boom_cylinder"},
        "did you mean 'boom_cylinder.cap_pressure'",
    ),
    "no pressures": (
        lambda c: {k: v for k, v in c.items() if "pressure" not in k},
        "no effort is measured",
    ),
}
SAMPLE = ("all in bar", "exchanged bucket", "stuck pressure", "stuck stroke", "clock ahead")


@pytest.mark.parametrize("name", swept(MISTAKES, SAMPLE))
def test_what_no_sensor_can_have_measured_is_no_number(lifted, name):
    folder, columns = lifted
    change, words = MISTAKES[name]
    data = write(folder / "mistake.csv", change(columns))
    answer = weigh(folder, data, "--json")
    assert answer.exit_code in (1, 2)
    error = json.loads(answer.stdout)["error"]["text"]
    assert re.search(words, error, re.DOTALL), error


def test_a_bag_is_weighed_as_its_columns_are(lifted, tmp_path):
    pytest.importorskip("rosbags")
    from hybrid_dynamics_ros.bags.input_topic import INPUT
    from hybrid_dynamics_ros.bags.recorded_pressures import PRESSURE_INPUT
    from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE
    from hybrid_dynamics_ros.messages.pressures import PRESSURES
    from tests.bags.messages import START, joint_state
    from tests.bags.test_pressures import CYLINDERS, pressures
    from tests.bags.test_pressures import write as write_bag

    folder, columns = lifted
    names = ("slew", *CYLINDERS)
    entries = []
    for k, second in enumerate(columns["time"]):
        stamp = START + round(second * 1e9)
        position = [columns[name][k] for name in names]
        entries.append((INPUT, JOINT_STATE, stamp, joint_state(stamp, names, position)))
        cap = [columns[f"{name}.cap_pressure"][k] for name in CYLINDERS]
        rod = [columns[f"{name}.rod_pressure"][k] for name in CYLINDERS]
        entries.append((PRESSURE_INPUT, PRESSURES, stamp, pressures(stamp, CYLINDERS, cap, rod)))
    bag = write_bag(tmp_path / "bag", entries)
    robot = ("--robot", str(folder / "robot.yaml"))
    weighed = data_of("weigh", str(bag), *robot)
    plain = data_of("weigh", write(folder / "lift.csv", columns), *robot)
    assert weighed["mass"] == pytest.approx(plain["mass"], abs=0.01)
    assert weighed["used"] > 0.8


def test_a_table_has_no_topics(lifted, tmp_path):
    folder, columns = lifted
    data = write(tmp_path / "lift.csv", columns)
    answer = weigh(folder, data, "--topic", "/joint_states")
    assert answer.exit_code == 2
    assert "--topic" in answer.output


def test_a_clock_in_milliseconds_is_refused(lifted, tmp_path):
    folder, columns = lifted
    counted = {**columns, "time": 1000.0 * columns["time"]}
    answer = weigh(folder, write(tmp_path / "lift.csv", counted))
    assert answer.exit_code == 2
    assert "milliseconds" in answer.output


def test_pressures_that_stay_above_the_supply_are_told_beside_the_mass(lifted, tmp_path):
    folder, columns = lifted
    data = write(tmp_path / "lift.csv", columns)
    assert data_of("weigh", data, "--robot", str(folder / "robot.yaml"))["notes"] == []
    limit = 0.8 * columns[BOOM].max()
    text = (folder / "robot.yaml").read_text(encoding="utf-8")
    text, count = re.subn(r"supply_pressure: [^,}\s]+", f"supply_pressure: {limit}", text)
    assert count == 3
    weak = tmp_path / "weak.yaml"
    weak.write_text(text, encoding="utf-8")
    (note,) = data_of("weigh", data, "--robot", str(weak))["notes"]
    margin = (columns[BOOM].max() - limit) * 1e-5
    assert note.startswith("boom_cylinder: a measured pressure of ")
    assert f"{margin:.4g} bar beyond its supply of {limit * 1e-5:.4g} bar" in note
