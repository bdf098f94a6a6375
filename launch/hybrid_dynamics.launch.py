"""Start the node: ros2 launch hybrid_dynamics_ros hybrid_dynamics.launch.py robot:=forging_chu2020."""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

PACKAGE = "hybrid_dynamics_ros"
ROBOT_TEXT = "Name of a shipped robot, or path of a description file. Empty: the one that params_file names"


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, then start the node with them."""
    shipped = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "forging_chu2020.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("robot", default_value="", description=ROBOT_TEXT),
            DeclareLaunchArgument("params_file", default_value=shipped, description="Parameters of the node"),
            OpaqueFunction(function=start_node),
        ]
    )


def start_node(context: LaunchContext) -> list[Node]:
    """Give the node the parameters of the file, then the robot where one is named."""
    robot = LaunchConfiguration("robot").perform(context)
    chosen = [{"robot": robot}] if robot else []
    return [
        Node(
            package=PACKAGE,
            executable="hybrid_dynamics_node",
            name="hybrid_dynamics",
            parameters=[LaunchConfiguration("params_file"), *chosen],
            output="screen",
        )
    ]
