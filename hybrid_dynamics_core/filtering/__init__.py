"""Joint states from what a machine carries: an error-state Kalman filter on closed loops."""

from .motion_model import MotionModel
from .observability import Observability, ObservabilityError, observability
from .sensor_file import SensorSet, default_motion, read_sensors, sensors_from_text
from .sensors import Kind, Quality, Sensor, imu, sensor_on_frame, sensor_on_joint
from .stream import Estimate, StateFilter
from .track import StateTrack, estimate_states

__all__ = [
    "Estimate",
    "Kind",
    "MotionModel",
    "Observability",
    "ObservabilityError",
    "Quality",
    "Sensor",
    "SensorSet",
    "StateFilter",
    "StateTrack",
    "default_motion",
    "estimate_states",
    "imu",
    "observability",
    "read_sensors",
    "sensor_on_frame",
    "sensor_on_joint",
    "sensors_from_text",
]
