"""The lifecycle node, which wires all parts.

Objects of a robot are created at configure and destroyed at cleanup.
"""

from __future__ import annotations

import gc
import traceback
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any, Final

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.exceptions import InvalidHandle, ParameterException
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from std_msgs.msg import String

from hybrid_dynamics_core import load
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.export import to_urdf
from hybrid_dynamics_core.ground.wording import one_line

from ..parameters import (
    AUTOSTART,
    DIAGNOSTICS_PERIOD,
    LOG_PERIOD,
    MEASURED,
    ROBOT,
    ChangeTime,
    NodeSettings,
    Parameter,
    ParameterError,
)
from ..stream.frames import frame_names
from ..stream.monitor import Level, StatusEntry
from ..stream.rate_limit import ThrottledLog
from ..stream.runtime import Runtime
from . import qos
from .declare_parameters import ParameterWatch, declare, declare_sensors, is_given
from .deferred_parameters import wait_for_code
from .diagnostics import diagnostic_array
from .event_free import EventFreeNode
from .payload_topic import PayloadTopic
from .service_server import ServiceServer
from .subscriptions import Stream
from .target_frames import target_frames

NODE_NAME: Final = "hybrid_dynamics"
UNCONFIGURED: Final = "stays unconfigured"  # beginning of the log line with the reason
SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class HybridDynamicsNode(EventFreeNode):
    """Topics and services of one robot.

    Raises:
        ParameterError: a given parameter is wrong.
    """

    def __init__(self, **options: Any) -> None:
        """Declare parameters and create services; options are those of rclpy's Node."""
        super().__init__(NODE_NAME, **options)
        self.settings: NodeSettings = declare(self)
        self._log = ThrottledLog(self.get_logger(), self.settings[LOG_PERIOD])
        self._runtime: Runtime | None = None
        self._stream: Stream | None = None
        self._payloads: PayloadTopic | None = None
        self._failure = ""  # reason why there is no robot
        # A context for work that may block the loop longer than usual.
        self.long_work: Callable[[], AbstractContextManager[None]] = nullcontext
        self._description = self.create_publisher(
            String, "robot_description", qos.transient_local()
        )
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._calls = ServiceServer(self, self._log)
        watch = ParameterWatch(self, lambda: self.settings, self._why_not, self._take)
        wait_for_code(self, watch, self._calls)
        # On steady time, so that reports continue while simulated time is paused.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(self.settings[DIAGNOSTICS_PERIOD], self._report, clock=steady)
        self._guard_transitions()

    def start(self) -> None:
        """Configure and activate, if the parameter autostart is set."""
        if self.settings[AUTOSTART] and self.trigger_configure() == SUCCESS:
            self.trigger_activate()

    def summary(self) -> str:
        """A line on the input so far."""
        runtime = self._runtime
        if runtime is None:
            return "no robot"
        return runtime.pipeline.counts.summary() + runtime.monitor.unprocessed()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the robot, and create its topics.

        If the file is wrong, the node stays unconfigured and logs the reason.
        """
        del state
        with self.long_work():
            return self._configure()

    def _configure(self) -> TransitionCallbackReturn:
        hint = f"; the default, -p {ROBOT.name}:=NAME_OR_FILE takes another"
        if is_given(self, ROBOT):
            hint = ""
        self.get_logger().info(f"robot {self.settings[ROBOT]}{hint}")
        try:
            robot = load(self.settings[ROBOT], xacro_args=self.settings.xacro_args)
            sensors = declare_sensors(self, self.settings[MEASURED] or robot.active)
            self.settings = self.settings.replaced(sensors)
            runtime = Runtime(robot, self.settings)
            self._stream = Stream(self, runtime, self._log)
            names = frame_names(robot, self.settings)
            targets = target_frames(self, names, self.settings)
            self._calls.offer_following(robot, self.settings)
        except (HybridDynamicsError, ParameterError, ParameterException, OSError) as error:
            return self._fail(one_line(error))
        except Exception:  # noqa: BLE001 - rclpy would not report a fault
            return self._fail(f"fault of the node:\n{traceback.format_exc()}")
        self._runtime, self._failure = runtime, ""
        # The robot's objects are frozen, since their garbage collection would delay the stream.
        gc.collect()
        gc.freeze()
        self._payloads = PayloadTopic(self, robot, names)
        runtime.payloads_changed = self._payloads.publish
        self._payloads.publish(runtime.conditions.payloads)
        self._calls.open(runtime, targets)
        self._description.publish(String(data=to_urdf(robot.description)))
        self.get_logger().info(f"robot {robot.name}: active joints {', '.join(robot.active)}")
        if runtime.measured != robot.active:
            self.get_logger().info(f"measured joints {', '.join(runtime.measured)}")
        return SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start processing the stream."""
        return self._set_active(state, active=True)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop processing the stream; services continue."""
        return self._set_active(state, active=False)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Destroy all objects of the robot."""
        del state
        if self._runtime is not None:
            self._description.publish(String())  # late subscribers get an empty description
        self.discard()
        return SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Destroy all objects of the robot; the node is finalised."""
        return self.on_cleanup(state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """After an error in a transition, return to unconfigured."""
        return self.on_cleanup(state)

    def discard(self) -> None:
        """Destroy all objects of the robot."""
        self._calls.active = False
        self._calls.close()
        if self._payloads is not None:
            self._payloads.destroy()
            self._payloads = None
        if self._stream is not None:
            self._stream.destroy()
        if self._runtime is not None:
            self.get_logger().info(f"stopped: {self.summary()}")
        self._stream = self._runtime = None
        gc.unfreeze()

    def _set_active(self, state: LifecycleState, *, active: bool) -> TransitionCallbackReturn:
        del state
        if self._stream is None or self._runtime is None:
            return FAILURE
        self._runtime.reset()
        self._stream.active = self._calls.active = active
        self.get_logger().info("active" if active else "inactive")
        return SUCCESS

    def _fail(self, reason: str) -> TransitionCallbackReturn:
        if self._stream is not None:
            self._stream.destroy()
        self._stream, self._failure = None, reason
        self.get_logger().error(f"{UNCONFIGURED}: {reason}")
        return FAILURE

    def _why_not(self, settings: NodeSettings, parameters: Sequence[Parameter[Any]]) -> str:
        """The reason why parameters cannot change; "" if they can."""
        if self._runtime is None:
            return ""
        for parameter in parameters:
            if parameter.change is ChangeTime.UNCONFIGURED:
                return f"parameter {parameter.name}: {parameter.change.value}"
        return self._runtime.problem(settings)

    def _take(self, settings: NodeSettings) -> None:
        self.settings = settings
        self._log.throttle.period = settings[LOG_PERIOD]
        if self._runtime is not None:
            self._runtime.take(settings)

    def _report(self) -> None:
        try:
            self._publish_report()
        except Exception as error:  # noqa: BLE001 - a timer must not end the node
            self._log.warn("report", f"no diagnostics: fault of the node: {error!r}")

    def _publish_report(self) -> None:
        now = self.get_clock().now()
        hardware = ""
        if self._runtime is not None:
            hardware = self._runtime.robot.name
        subjects = {
            "robot": self._robot_report(),
            "workers": self._calls.worker_report(),
            "services": self._calls.counts.report(),
            "stream": self._stream_report(now.nanoseconds),
        }
        state: str = self._state_machine.current_state[1]
        name = self.get_fully_qualified_name()
        self._diagnostics.publish(diagnostic_array(name, hardware, state, subjects, now.to_msg()))

    def _robot_report(self) -> list[StatusEntry]:
        runtime = self._runtime
        if runtime is None:
            level = Level.ERROR if self._failure else Level.STALE
            return [StatusEntry("robot", self._failure or "not configured", level)]
        entries = [StatusEntry("robot", runtime.robot.name)]
        if runtime.result is not None:
            entries += runtime.monitor.robot_report(runtime.result, self.settings)
        return entries

    def _stream_report(self, now_ns: int) -> list[StatusEntry]:
        runtime, stream = self._runtime, self._stream
        if runtime is None or stream is None:
            return [StatusEntry("stream", "not configured", Level.STALE)]
        stream.check_connections()
        counts = runtime.pipeline.counts
        return runtime.monitor.report(runtime.result, counts, now_ns, self.settings)

    def _guard_transitions(self) -> None:
        """Answer transitions that the state does not allow with success=False.

        In rclpy they would end the node.
        """
        change: Callable[[Any, Any], Any] = self._service_change_state.callback

        def guarded(request: Any, response: Any) -> Any:
            try:
                return change(request, response)
            except (RuntimeError, InvalidHandle) as error:
                wanted = request.transition.label or request.transition.id
                state = self._state_machine.current_state[1]
                self._log.warn(
                    "transition", f"transition {wanted} is not possible while {state}: {error}"
                )
                response.success = False
                return response

        self._service_change_state.callback = guarded
