"""The node's process: arguments, signals, loop, exit code."""

from __future__ import annotations

import os
import sys
from typing import Final

from .process.stop_signals import StopSignals
from .process.watchdog import Watchdog

# A short interval gives the stream the interpreter sooner, while a thread loads code.
_SWITCH_INTERVAL: Final = 5e-4  # [s]
_MAX_WAIT: Final = 0.5  # [s] for an event; the longest time between beats of the loop
_USAGE: Final = (
    "usage: hybrid_dynamics_node --ros-args [-p robot:=NAME_OR_FILE] [--params-file FILE] [-r"
    " __node:=NAME]"
)
_MORE: Final = """
The node of one robot: a name of a shipped robot, or the path of a description file. It runs until
SIGINT (Ctrl-C) or SIGTERM; a second one ends it at once. Parameters, with defaults, units and
texts, are in config/forging_chu2020.yaml; docs/node_reference.md lists topics and services.
"""
_NO_ROS: Final = """\
hybrid_dynamics_node needs ROS 2 Jazzy: the Python module {name} is not there.
  with a ROS installation:  source /opt/ros/jazzy/setup.bash, build hybrid_dynamics_msgs with colcon
  without one:              pip install ./msg_defs ".[ros]"   (or: make setup)
"""


def main(args: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM. Returns the exit code of the process."""
    words = sys.argv if args is None else args
    if "-h" in words[1:] or "--help" in words[1:]:
        sys.stdout.write(f"{_USAGE}\n{_MORE}")
        return 0
    # Without a sourced ROS installation, packages are in this Python's prefix.
    os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)
    # Matrices are small, and threads of OpenBLAS would only wait for each other.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.setswitchinterval(_SWITCH_INTERVAL)
    # Asynchronous publishing: slow readers do not block the stream.
    os.environ.setdefault("RMW_FASTRTPS_PUBLICATION_MODE", "ASYNCHRONOUS")
    stop = StopSignals()
    # Imported late: it is slow, and the usage above does not need it.
    from hybrid_dynamics_core.kernels.cache import at_least_meanwhile  # noqa: PLC0415

    try:
        with at_least_meanwhile():
            code = _run(words, stop)
    except ModuleNotFoundError as error:
        sys.stderr.write(_NO_ROS.format(name=error.name))
        code = 1
    stop.ignore()
    return code


def _run(args: list[str], stop: StopSignals) -> int:
    # Messages import rosidl_generator_py, which would import its parser and its templates too. It
    # does without where they are missing: only the generation of messages needs them.
    sys.modules.setdefault("rosidl_generator_py.generate_py_impl", None)  # type: ignore[arg-type]
    # Imported late: a machine without ROS gets a sentence instead of a traceback.
    import rclpy  # noqa: PLC0415
    from rclpy.exceptions import ParameterException  # noqa: PLC0415
    from rclpy.signals import SignalHandlerOptions  # noqa: PLC0415
    from rclpy.utilities import remove_ros_args, try_shutdown  # noqa: PLC0415

    from ..parameters import ParameterError  # noqa: PLC0415

    try:
        # rclpy's signal handlers would end the context while the node still uses it.
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:  # wrong ROS arguments
        return _failed(error)
    try:
        _refuse_others(remove_ros_args(args)[1:])
        _spin(stop)
    except (ParameterError, ParameterException) as error:
        return _failed(error)
    finally:
        try_shutdown()
    return 0


def _spin(stop: StopSignals) -> None:
    from rclpy.utilities import ok  # noqa: PLC0415

    from .executor import make_executor  # noqa: PLC0415
    from .library_log import forwarded  # noqa: PLC0415
    from .lifecycle import HybridDynamicsNode  # noqa: PLC0415

    node = HybridDynamicsNode()
    watchdog = Watchdog()
    node.long_work = watchdog.patient
    try:
        with forwarded(node.get_logger()):
            executor = make_executor()
            executor.add_node(node)
            node.start()
            # spin() of the events executor does not return on signals.
            while ok() and not stop.requested.is_set():
                watchdog.beat()
                executor.spin_once(timeout_sec=_MAX_WAIT)
            executor.shutdown()
    finally:
        node.discard()
        node.destroy_node()
        watchdog.stop()


def _refuse_others(arguments: list[str]) -> None:
    """Refuse arguments that are no ROS arguments, since ignoring them may start a wrong robot.

    Raises:
        ParameterError: there is one.
    """
    from ..parameters import ParameterError  # noqa: PLC0415

    if arguments:
        raise ParameterError(f"cannot use {' '.join(arguments)}; {_USAGE}")


def _failed(error: Exception) -> int:
    """Print one line on why the node failed; returns the exit code."""
    from rclpy.logging import get_logger  # noqa: PLC0415

    from hybrid_dynamics_core.ground.wording import one_line  # noqa: PLC0415

    get_logger("hybrid_dynamics").fatal(one_line(error))
    return 1
