"""Processes that take long to end do not stop the node from ending."""

from __future__ import annotations

import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.services import worker_pool
from hybrid_dynamics_ros.services.worker_pool import WorkerPool


def test_a_pool_closes_though_its_processes_take_longer_to_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(worker_pool, "_END_TIMEOUT", 0.0)
    WorkerPool(load("five_bar").description).close()
