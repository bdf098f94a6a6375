"""A graph of its own for each run."""

import os
import socket
from unittest import mock

import pytest

from hybrid_dynamics_ros.demo.play.domain import is_silent, private_domain


@pytest.fixture(autouse=True)
def environment():
    """The environment is given back."""
    with mock.patch.dict(os.environ):
        yield


def test_two_runs_at_a_time_get_different_domains():
    with private_domain(None) as first, private_domain(None) as second:
        assert first != second


def test_the_graph_stays_on_this_machine():
    with private_domain(None) as domain:
        assert os.environ["ROS_DOMAIN_ID"] == str(domain)
        assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


def test_a_given_domain_is_used():
    with private_domain(17) as domain:
        assert domain == 17
        assert os.environ["ROS_DOMAIN_ID"] == "17"


def test_a_domain_where_someone_listens_is_not_silent():
    with private_domain(None) as domain, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        assert is_silent(domain)
        other.bind(("", 7400 + 250 * domain + 12))
        assert not is_silent(domain)
