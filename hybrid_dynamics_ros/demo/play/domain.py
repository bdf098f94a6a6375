"""A private ROS domain for each run, on this machine only."""

from __future__ import annotations

import fcntl
import os
import socket
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from ..errors import DemoError

# From 102 on, ports overlap with Linux's ephemeral ports.
DOMAINS: Final = range(1, 102)
_PARTICIPANTS: Final = 10
# Ports of discovery (RTPS 2.5, 9.6.2).
_FIRST_PORT: Final = 7400
_PORTS_PER_DOMAIN: Final = 250
_UNICAST_OFFSET: Final = 10
_PROFILES: Final = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")


@contextmanager
def private_domain(domain: int | None) -> Iterator[int]:
    """Reserve a domain, and set the environment of this process and its children.

    Args:
        domain: the domain, without a check; None for any unused one.

    Raises:
        DemoError: no domain is free.
    """
    if domain is not None:
        _set_environment(domain)
        yield domain
        return
    with _free_domain() as number:
        _set_environment(number)
        yield number


def _set_environment(domain: int) -> None:
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ.pop("ROS_LOCALHOST_ONLY", None)  # the older variable takes precedence
    os.environ.pop("ROS_STATIC_PEERS", None)
    if not any(name in os.environ for name in _PROFILES):
        os.environ[_PROFILES[0]] = str(Path(__file__).with_name("quick_discovery.xml"))
    # ROS from PyPI has only one middleware.
    if "AMENT_PREFIX_PATH" not in os.environ:
        os.environ["AMENT_PREFIX_PATH"] = sys.prefix
        os.environ.pop("RMW_IMPLEMENTATION", None)


@contextmanager
def _free_domain() -> Iterator[int]:
    """A domain without participants.

    A lock file reserves it for the duration of the run.
    """
    first = os.getpid() % len(DOMAINS)
    for domain in (*DOMAINS[first:], *DOMAINS[:first]):
        path = Path(tempfile.gettempdir()) / f"ros_domain_{domain}.{os.getuid()}.lock"
        with path.open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            if is_silent(domain):
                yield domain
                return
    raise DemoError("every ROS domain of this machine is in use; choose one with --domain")


def is_silent(domain: int) -> bool:
    """Whether no participant of this machine listens on the discovery ports of a domain."""
    first = _FIRST_PORT + _PORTS_PER_DOMAIN * domain + _UNICAST_OFFSET
    for participant in range(_PARTICIPANTS):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", first + 2 * participant))
            except OSError:
                return False
    return True
