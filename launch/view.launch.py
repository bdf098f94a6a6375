"""Start the node, robot_state_publisher and RViz, which have to be installed.

ros2 launch hybrid_dynamics_ros view.launch.py robot:=excavator
"""

from ament_index_python import PackageNotFoundError, get_package_prefix
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from hybrid_dynamics_core import load
from hybrid_dynamics_core.export import to_urdf

SHARE = FindPackageShare("hybrid_dynamics_ros")


def generate_launch_description() -> LaunchDescription:
    """The node as the other launch file starts it, and what shows the robot."""
    robot = DeclareLaunchArgument(
        "robot", default_value="forging_chu2020", description="Shipped robot, or a file"
    )
    node = IncludeLaunchDescription(
        PathJoinSubstitution([SHARE, "launch", "hybrid_dynamics.launch.py"]),
        launch_arguments={"robot": LaunchConfiguration("robot")}.items(),
    )
    return LaunchDescription([robot, node, OpaqueFunction(function=show)])


def show(context: LaunchContext) -> list[Node]:
    """robot_state_publisher on the full joint state, and RViz.

    The base frame of the robot is RViz's fixed frame.
    """
    for package in ("robot_state_publisher", "rviz2"):
        require(package)
    robot = load(LaunchConfiguration("robot").perform(context))
    publisher = Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        parameters=[{"robot_description": to_urdf(robot.description)}],
        remappings=[("joint_states", "hybrid_dynamics/joint_states")],
    )
    config = PathJoinSubstitution([SHARE, "rviz", "robot.rviz"])
    rviz = Node(
        package="rviz2", executable="rviz2", arguments=["-d", config, "-f", robot.base_frame]
    )
    return [publisher, rviz]


def require(package: str) -> None:
    """Raise where a package is missing: only this file needs it, so that it is no dependency."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError as error:
        name = f"ros-jazzy-{package.replace('_', '-')}"
        raise RuntimeError(f"{package} is not installed: sudo apt install {name}") from error
