"""What counts as a good run."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from hybrid_dynamics_ros.demo.judge.verdict import judge
from hybrid_dynamics_ros.demo.run import Files, summary
from hybrid_dynamics_ros.demo.topics import EFFORTS, INPUT, POSE, STATES

FILES = Files(Path("results"), Path("figure.png"), Path("figure.svg"))


def rows(series, keep):
    """The rows of a series that are kept."""
    fields = {
        name: table[keep] for name, table in vars(series).items() if isinstance(table, np.ndarray)
    }
    return replace(series, **fields)


def test_a_complete_run_is_good(expected, results, robot):
    verdict = judge(expected, results, robot)
    assert verdict.good
    assert verdict.lost == 0
    assert verdict.received == {INPUT: 1001, STATES: 1001, EFFORTS: 998, POSE: 1001}
    assert verdict.delay == (0.0007, 0.0007)
    text = summary(verdict, FILES)
    assert "0 messages lost" in text
    assert "FAILED" not in text
    assert max(map(len, text.splitlines())) <= 80


def test_the_filter_takes_the_efforts_of_the_first_samples_only(expected):
    assert not expected.with_efforts[:3].any()
    assert expected.with_efforts[3:].all()


def test_at_constant_rates_the_filter_says_no_acceleration_to_the_last_bit(expected):
    assert not expected.acceleration[expected.with_efforts].any()


def test_a_message_that_did_not_come_is_lost(expected, results, robot):
    keep = np.arange(998) != 500
    verdict = judge(expected, replace(results, efforts=rows(results.efforts, keep)), robot)
    assert verdict.lost == 1
    assert not verdict.good
    assert "FAILED: 1 messages were lost" in summary(verdict, FILES)


def test_a_message_that_came_twice_does_not_stand_for_a_lost_one(expected, results, robot):
    keep = np.arange(1001)
    keep[7] = 6
    assert judge(expected, replace(results, pose=rows(results.pose, keep)), robot).lost == 1


def test_a_wrong_effort_is_found(expected, results, robot):
    effort = results.efforts.effort.copy()
    effort[300, 2] *= 1.0 + 1e-6
    verdict = judge(
        expected, replace(results, efforts=replace(results.efforts, effort=effort)), robot
    )
    assert verdict.lost == 0
    assert not verdict.good
    np.testing.assert_allclose(verdict.difference, 1e-6 * abs(effort[300, 2]), rtol=1e-3)
    assert "FAILED: the efforts" in summary(verdict, FILES)


def test_the_order_of_the_joints_in_the_messages_does_not_matter(expected, results, robot):
    efforts = results.efforts
    turned = replace(efforts, names=efforts.names[::-1], effort=efforts.effort[:, ::-1])
    assert judge(expected, replace(results, efforts=turned), robot).good


def test_a_run_without_efforts_is_not_good(expected, results, robot):
    verdict = judge(expected, replace(results, efforts=rows(results.efforts, slice(0, 0))), robot)
    assert verdict.lost == 998
    assert not verdict.good
    assert "FAILED" in summary(verdict, FILES)
