"""A graph of its own for every run, the node in its own process, and a client in this one."""

# ruff: noqa: E402 - the environment is set before anything imports rclpy or a message.

import fcntl
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from pathlib import Path

import pytest

from hybrid_dynamics_ros.demo.play.domain import is_silent

ROOT = Path(__file__).resolve().parents[2]
CHANGING = ("change_state", "set_parameters", "set_parameters_atomically")
DEADLINE = 60.0  # [s], for anything that should happen at once on an idle machine


def _take_domain():
    """A domain that no other run on this machine has: the lock is held while this process lives."""
    start = os.getpid() % 100
    for offset in range(100):
        domain = 1 + (start + offset) % 100  # above 101 the ports reach into those that clients get
        path = Path(tempfile.gettempdir()) / f"ros_domain_{domain}.{os.getuid()}.lock"
        lock = os.open(path, os.O_CREAT | os.O_RDWR, 0o600)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(lock)
            continue
        if is_silent(domain):  # nor anything else
            return domain
        os.close(lock)
    raise RuntimeError("all ROS domains of this machine are taken")


os.environ["ROS_DOMAIN_ID"] = str(_take_domain())
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"
os.environ.setdefault("ROS_LOG_DIR", tempfile.mkdtemp(prefix="ros_log_"))
os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)
os.environ.pop("RMW_IMPLEMENTATION", None)

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from hybrid_dynamics_msgs.msg import CylinderStates, JointMotion
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.type_support import check_for_type_support
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.node.publishers import message_class
from hybrid_dynamics_ros.services.table import TABLE as SERVICES
from hybrid_dynamics_ros.stream.topics import TOPICS

with warnings.catch_warnings():
    # LoadPattern the first message type brings in a parser that uses a deprecated module of Python.
    warnings.simplefilter("ignore", DeprecationWarning)
    check_for_type_support(JointState)


def wait_until(condition, what, deadline=DEADLINE):
    """Polls until the condition holds; its value."""
    end = time.monotonic() + deadline
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise AssertionError(f"not within {deadline} s: {what}")
        time.sleep(0.005)


class NodeProcess:
    """The node in a process of its own; all it prints goes to a file."""

    def __init__(self, folder, *arguments, command=None, environment=None):
        self._log = Path(tempfile.mkstemp(suffix=".log", dir=folder)[1])
        command = command or [sys.executable, "-m", "hybrid_dynamics_ros.node"]
        with self._log.open("w") as log:
            self.process = subprocess.Popen(
                [*command, *(["--ros-args", *arguments] if arguments else [])],
                cwd=ROOT,
                env={**os.environ, **(environment or {})},
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    def output(self):
        return self._log.read_text()

    def wait_for(self, pattern, deadline=DEADLINE):
        """Waits for a line of the log; a node that died fails at once."""

        def found():
            text = self.output()
            if (match := re.search(pattern, text)) is None and self.process.poll() is not None:
                match = re.search(pattern, self.output())
                assert match, f"the node ended with {self.process.returncode} and said:\n{text}"
            return match

        return wait_until(found, f"{pattern!r} in the node's log", deadline)

    def finish(self, deadline=DEADLINE):
        """Exit code, once the node has ended; its words go to the report of a test that fails."""
        code = self.process.wait(deadline)
        print(self.output())  # noqa: T201
        return code

    def stop(self, number=signal.SIGINT, deadline=DEADLINE):
        """Sends a signal; exit code."""
        self.process.send_signal(number)
        return self.finish(deadline)

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()


class Client:
    """A node of this process that talks to the node under test, spinning in a thread."""

    wait_until = staticmethod(wait_until)

    def __init__(self, namespace="/hybrid_dynamics"):
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node("tester", context=self._context)
        self._received = {}
        self._publishers = {
            name: self._node.create_publisher(kind, f"{namespace}/{name}", 500)
            for name, kind in (
                ("active_joint_states", JointState),
                ("active_joint_motions", JointMotion),
                ("cylinder_pressures", CylinderStates),
                ("joint_trajectory", JointTrajectory),
            )
        }
        self._subscriptions = {
            name: self._node.create_subscription(
                kind, f"{namespace}/{name}", self._collector(name), 500
            )
            for name, kind in (
                *((topic.name, message_class(topic.kind)) for topic in TOPICS),
                ("active_joint_trajectory", JointTrajectory),
            )
        }
        self.diagnostics = []
        self._node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)
        self._services = {
            name: self._node.create_client(
                kind, f"{namespace}/{name}", qos_profile=QoSProfile(depth=500)
            )
            for name, kind in (
                *((service.name, service.kind) for service in SERVICES),
                ("change_state", ChangeState),
                ("get_state", GetState),
                ("set_parameters", SetParameters),
                ("get_parameters", GetParameters),
                ("list_parameters", ListParameters),
            )
        }
        self._name = namespace
        self._answered = set()
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()
        self._stamp_ns = 1_000_000_000_000

    def _collector(self, topic):
        messages = self._received.setdefault(topic, {})

        def collect(message):
            messages[message.header.stamp.sec * 10**9 + message.header.stamp.nanosec] = message

        return collect

    def connect(self):
        """Waits until every topic and service is there, then until a message has gone all the way
        round.
        """
        for name, publisher in self._publishers.items():
            wait_until(publisher.get_subscription_count, f"a subscription on {name}")
        for name, subscription in self._subscriptions.items():
            wait_until(subscription.get_publisher_count, f"a publisher on {name}")
        # The node's publishers may learn of this process later than this process of them.
        probe = JointMotion(
            name=["q1", "q12", "q22", "q4"],
            position=[0.0, 0.1, 0.15, 0.0],
            velocity=[0.0] * 4,
            acceleration=[0.0] * 4,
        )

        def round_trip():
            self.publish("active_joint_motions", probe, self.new_stamp())
            time.sleep(0.05)
            wanted = (
                "joint_states",
                "required_efforts",
                "closed_state",
                "end_effector_pose",
                "end_effector_twist",
            )
            return all(self._received[name] for name in wanted)

        wait_until(round_trip, "an answer on every topic")
        return self

    def connect_service(self, name):
        """The service once it answers; where any call would change the node, once it is there."""
        service = self._services[name]
        if name not in self._answered:
            assert service.wait_for_service(DEADLINE), f"no service {name}"
            question = service.srv_type.Request()
            if (
                name not in CHANGING
            ):  # a first answer is lost where the node has not found its reader yet
                wait_until(lambda: service.call(question, timeout_sec=5.0), f"an answer of {name}")
            self._answered.add(name)
        return service

    def _on_diagnostics(self, message):
        self.diagnostics += [
            status for status in message.status if status.name.startswith(self._name.lstrip("/"))
        ]

    def report(self, subject):
        """The newest status of a subject: stream, services, workers or robot; None so far."""
        ending = f": {subject}"
        statuses = [status for status in self.diagnostics if status.name.endswith(ending)]
        return statuses[-1] if statuses else None

    def values(self, subject):
        """The newest values of a subject, by their names."""
        status = self.report(subject)
        return {} if status is None else {entry.key: entry.value for entry in status.values}

    def change(self, transition):
        """Asks for a transition by name; whether it was done."""
        request = ChangeState.Request()
        request.transition.label = transition
        return self.call("change_state", request).success

    def state(self):
        return self.call("get_state", GetState.Request()).current_state.label

    def set_parameter(self, name, value):
        """Sets a parameter; why not, or an empty text."""
        request = SetParameters.Request(
            parameters=[rclpy.Parameter(name, value=value).to_parameter_msg()]
        )
        (result,) = self.call("set_parameters", request).results
        return "" if result.successful else result.reason

    def parameters(self):
        """Every parameter that the node lists, with its value as a message."""
        listed = self.call("list_parameters", ListParameters.Request()).result.names
        values = self.call("get_parameters", GetParameters.Request(names=listed)).values
        return dict(zip(listed, values, strict=True))

    def call_async(self, service, request):
        return self.connect_service(service).call_async(request)

    def new_stamp(self, after_s=10.0):
        """A stamp [ns] so much later than the last one."""
        self._stamp_ns += round(after_s * 1e9)
        return self._stamp_ns

    def advertise(self, kind, topic):
        """Publishes a further topic, by its whole name; the node listens to it afterwards."""
        publisher = self._publishers[topic] = self._node.create_publisher(kind, topic, 500)
        wait_until(publisher.get_subscription_count, f"a subscription on {topic}")

    def publish(self, topic, message, stamp_ns):
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
        self._publishers[topic].publish(message)

    def publish_as_it_is(self, topic, message):
        self._publishers[topic].publish(message)

    def wait_for(self, topic, stamp_ns):
        """The message of a topic with this stamp."""
        messages = self._received[topic]
        return wait_until(lambda: messages.get(stamp_ns), f"{topic} with stamp {stamp_ns}")

    def received(self, topic, stamp_ns):
        """The message of a topic with this stamp, or None so far."""
        return self._received[topic].get(stamp_ns)

    def call(self, service, request):
        response = self.connect_service(service).call(request, timeout_sec=DEADLINE)
        assert response is not None, f"{service} did not answer"
        return response

    def node_names(self):
        """Full names of the nodes in the graph."""
        return {
            f"{space.rstrip('/')}/{name}"
            for name, space in self._node.get_node_names_and_namespaces()
        }

    def topic_names(self):
        """Full names of the topics in the graph."""
        return {name for name, _ in self._node.get_topic_names_and_types()}

    def between_turns(self, call, *arguments):
        """Runs it in the spinning thread, which dies of entities that go while it waits."""
        task = self._executor.create_task(call, *arguments)
        wait_until(task.done, "a turn of the executor")
        return task.result()

    def _spin(self):
        while not self._closing.is_set():
            self._executor.spin_once(timeout_sec=0.1)

    def close(self):
        self._closing.set()
        self._thread.join(DEADLINE)
        self._executor.shutdown()  # not before: an executor that spins does not survive it
        self._node.destroy_node()
        self._context.try_shutdown()


@pytest.fixture
def start_node(tmp_path):
    """Starts nodes that end with the test."""
    started = []

    def start(*arguments, **options):
        started.append(NodeProcess(tmp_path, *arguments, **options))
        return started[-1]

    yield start
    for process in started:
        process.kill()


@pytest.fixture
def connect():
    """Makes connected clients that end with the test."""
    clients = []

    def make(namespace="/hybrid_dynamics", only=()):
        clients.append(Client(namespace))
        for name in only:  # services alone: the node may be unconfigured
            clients[-1].connect_service(name)
        return clients[-1] if only else clients[-1].connect()

    yield make
    for client in clients:
        client.close()


@pytest.fixture(scope="module")
def node(tmp_path_factory):
    """One node for the tests of a module; every line about bad input is logged."""
    process = NodeProcess(tmp_path_factory.mktemp("node"), "-p", "log_period:=0.0")
    yield process
    process.kill()


@pytest.fixture(scope="module")
def client(node):
    """A client connected to that node."""
    node.wait_for("active joints")
    made = Client()
    yield made.connect()
    made.close()


@pytest.fixture(scope="session")
def robot():
    return load("forging_chu2020")
