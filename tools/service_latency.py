"""How long calls of the node take, alone and beside a long conversion, and those of a bare service.

python tools/service_latency.py [CALLS]

The bare service is rclpy's own, in a process of its own: it answers at once, with the types of the
node's service. Calls go to it and to the node by turns, so that both meet the same machine.
"""

import subprocess
import sys
import threading
import time

import rclpy
from hybrid_dynamics_msgs.action import ConvertTrajectory
from hybrid_dynamics_msgs.srv import SolveFK, SolveIK
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

ACTIVE = ["q1", "q12", "q22", "q4"]
START = [0.0, 0.1, 0.15, 0.0]
BARE = """
import contextlib, rclpy
from hybrid_dynamics_msgs.srv import SolveFK, SolveIK
rclpy.init()
node = rclpy.create_node("bare")
node.create_service(SolveFK, "/bare/solve_fk", lambda _, response: response)
node.create_service(SolveIK, "/bare/solve_ik", lambda _, response: response)
with contextlib.suppress(rclpy.executors.ExternalShutdownException):
    rclpy.spin(node)
"""
PATIENCE = 120.0  # [s]


def requests() -> dict[str, tuple[type, object]]:
    """A call of each service."""
    joints = JointState(name=ACTIVE, position=START)
    target = SolveIK.Request(position_only=True, seed=joints)
    place = target.target.pose.position
    place.x, place.y, place.z = 0.3226478557853928, 0.38451674127506036, 1.1179125884719605
    return {
        "solve_fk": (SolveFK, SolveFK.Request(active_joints=joints)),
        "solve_ik": (SolveIK, target),
    }


def long_goal() -> ConvertTrajectory.Goal:
    """A conversion that takes minutes."""
    goal = ConvertTrajectory.Goal(joints=JointTrajectory(joint_names=ACTIVE))
    for second in range(20_000):
        point = JointTrajectoryPoint(positions=[0.1 * (second % 2), *START[1:]])
        point.time_from_start.sec = second
        goal.joints.points.append(point)
    return goal


def measure(clients: dict[str, object], request: object, calls: int) -> None:
    """Call all clients by turns, and print what it took."""
    took: dict[str, list[float]] = {name: [] for name in clients}
    for _ in range(calls):
        for name, client in clients.items():
            begin = time.perf_counter()
            answer = client.call(request, timeout_sec=PATIENCE)
            took[name].append(time.perf_counter() - begin)
            if answer is None or answer.error_code:
                sys.exit(f"{name}: {answer}")
    for name, times in took.items():
        times.sort()
        middle, late = (1e3 * times[int(share * len(times))] for share in (0.5, 0.99))
        print(f"  {name}: median {middle:.2f} ms, 99 % {late:.2f} ms", flush=True)


def main(calls: int) -> None:
    """Measure alone, then beside a conversion."""
    commands = [[sys.executable, "-m", "hybrid_dynamics_ros.node"], [sys.executable, "-c", BARE]]
    processes = [subprocess.Popen(command) for command in commands]
    rclpy.init()
    node = rclpy.create_node("caller")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    conversion = ActionClient(node, ConvertTrajectory, "/hybrid_dynamics/convert_trajectory")
    clients = {
        name: {of: node.create_client(kind, f"/{of}/{name}") for of in ("hybrid_dynamics", "bare")}
        for name, (kind, _) in requests().items()
    }
    try:
        for situation in ("alone", "beside a conversion"):
            for name, (_, request) in requests().items():
                for client in clients[name].values():
                    client.wait_for_service(PATIENCE)
                    client.call(request, timeout_sec=PATIENCE)
                print(f"{name}, {situation}:", flush=True)
                measure(clients[name], request, calls)
            conversion.wait_for_server(PATIENCE)
            conversion.send_goal_async(long_goal())
            time.sleep(3.0)
    finally:
        for process in processes:
            process.terminate()
            process.wait()


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
