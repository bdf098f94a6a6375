"""Try what colcon built: imports, shared files, and a call that the node answers.

python tools/try_install.py INSTALL (in an environment where INSTALL/setup.bash was sourced)

The node is started as `ros2 run` would start it.
"""

import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import rclpy
from ament_index_python import get_package_share_directory
from hybrid_dynamics_msgs.msg import ErrorCode
from hybrid_dynamics_msgs.srv import SolveFK
from sensor_msgs.msg import JointState

from hybrid_dynamics_ros.demo.play.domain import private_domain

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "hybrid_dynamics_ros"
SHARED = (
    "package.xml",
    "launch/hybrid_dynamics.launch.py",
    "config/forging_chu2020.yaml",
    "rviz/robot.rviz",
)
PATIENCE = 30.0  # [s] for the node to come up, to answer and to end


def main(install: Path) -> None:
    """Try everything; the first failure ends the program with its reason."""
    for name in ("hybrid_dynamics_core", "hybrid_dynamics_ros", "hybrid_dynamics_msgs"):
        folder = Path(str(import_module(name).__file__)).parent
        require(folder.is_relative_to(install), f"{name} comes from {folder}, not from {install}")
        absent = missing(name, folder)
        require(not absent, f"not installed from {name}: {', '.join(absent)}")
    share = Path(get_package_share_directory(PACKAGE))
    for name in SHARED:
        require((share / name).is_file(), f"{share / name} is missing")
    print("  packages and shared files: found", flush=True)

    executable = install / PACKAGE / "lib" / PACKAGE / "hybrid_dynamics_node"
    parameters = share / "config" / "forging_chu2020.yaml"
    node = subprocess.Popen([executable, "--ros-args", "--params-file", parameters])
    try:
        call_forward_kinematics(node)
        node.send_signal(signal.SIGINT)
        require(node.wait(PATIENCE) == 0, f"the node ended with code {node.returncode}")
    finally:
        node.kill()
    print("  node: started, answered a call, ended cleanly", flush=True)


def missing(package: str, installed: Path) -> list[str]:
    """Source files of a package, data included, that were not installed."""
    source = ROOT / package
    absent = []
    for path in source.rglob("*"):
        file = path.relative_to(source)
        if not path.is_file() or "__pycache__" in file.parts:
            continue
        if not (installed / file).exists():
            absent.append(str(file))
    return absent


def call_forward_kinematics(node: subprocess.Popen[bytes]) -> None:
    """Ask the running node for one pose."""
    rclpy.init()
    client_node = rclpy.create_node("try_install")
    client = client_node.create_client(SolveFK, "/hybrid_dynamics/solve_fk")
    deadline = time.monotonic() + PATIENCE
    while not client.wait_for_service(0.5):
        require(node.poll() is None, f"the node ended with code {node.returncode}")
        require(time.monotonic() < deadline, "the service solve_fk did not come up")
    active = JointState(name=["q1", "q12", "q22", "q4"], position=[0.0, 0.15, 0.175, 0.0])
    while True:  # the service is there before the robot is
        future = client.call_async(SolveFK.Request(active_joints=active))
        rclpy.spin_until_future_complete(client_node, future, timeout_sec=PATIENCE)
        answer = future.result()
        require(answer is not None, "solve_fk did not answer")
        if answer.error_code != ErrorCode.NOT_READY or time.monotonic() > deadline:
            break
        time.sleep(0.1)
    is_right = answer.error_code == ErrorCode.OK and len(answer.poses) == 1
    require(is_right, f"solve_fk answered {answer}")
    rclpy.shutdown()


def require(condition: bool, text: str) -> None:
    """End with the text unless the condition holds."""
    if not condition:
        sys.exit(f"FAILED: {text}")


if __name__ == "__main__":
    with private_domain(None):  # nobody else's nodes, and nobody else sees these
        main(Path(sys.argv[1]).absolute())
