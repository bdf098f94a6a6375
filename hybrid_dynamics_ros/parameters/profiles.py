"""Names of QoS profiles."""

from __future__ import annotations

from typing import Final

RELIABLE: Final = "reliable"
BEST_EFFORT: Final = "best_effort"
SENSOR_DATA: Final = "sensor_data"
LATEST: Final = "latest"
PROFILES: Final = (RELIABLE, BEST_EFFORT, SENSOR_DATA, LATEST)
