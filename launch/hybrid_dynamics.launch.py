"""Start the node: ros2 launch hybrid_dynamics_ros hybrid_dynamics.launch.py robot:=excavator."""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "hybrid_dynamics_ros"
RESPAWN_DELAY = 1.0  # [s]
ARGUMENTS = (
    ("robot", "forging_chu2020", "Name of a shipped robot, or path of a description file"),
    ("params_file", "", "File with parameters of the node. Empty: defaults"),
    ("name", "hybrid_dynamics", "Name of the node"),
    ("namespace", "", "Namespace of the node"),
    ("autostart", "true", "Configure and activate at once; false: a lifecycle manager does"),
    ("use_sim_time", "false", "Time from /clock"),
    ("qos", "", "Quality of service of all topics, as the parameters qos.* have it. Empty: theirs"),
    ("log_level", "info", "debug, info, warn, error or fatal"),
    ("respawn", "false", "Start the node again where it ends with an error"),
)


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, then start the node with them."""
    actions = []
    for name, default, text in ARGUMENTS:
        actions.append(DeclareLaunchArgument(name, default_value=default, description=text))
    return LaunchDescription([*actions, OpaqueFunction(function=start_node)])


def start_node(context: LaunchContext) -> list[Node]:
    """Give the node the parameters of the file, then those of the arguments, which win."""
    given = {name: LaunchConfiguration(name).perform(context) for name, _, _ in ARGUMENTS}
    parameters = []
    if given["params_file"]:
        parameters.append(given["params_file"])
    arguments = {
        "robot": given["robot"],
        "autostart": given["autostart"] == "true",
        "use_sim_time": given["use_sim_time"] == "true",
    }
    if given["qos"]:
        arguments |= {"qos.input": given["qos"], "qos.output": given["qos"]}
    parameters.append(arguments)
    node = Node(
        package=PACKAGE,
        executable="hybrid_dynamics_node",
        name=given["name"],
        namespace=given["namespace"],
        parameters=parameters,
        ros_arguments=["--log-level", given["log_level"]],
        respawn=given["respawn"] == "true",
        respawn_delay=RESPAWN_DELAY,
        output="screen",
    )
    return [node]
