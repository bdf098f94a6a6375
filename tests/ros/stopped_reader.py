"""For tests: prints the stamp [ns] of each JointState of a topic, in a process of its own."""

import sys

import rclpy
from sensor_msgs.msg import JointState


def tell(message):
    stamp = message.header.stamp
    sys.stdout.write(f"{stamp.sec * 10**9 + stamp.nanosec}\n")
    sys.stdout.flush()


rclpy.init()
node = rclpy.create_node("reader")
node.create_subscription(JointState, sys.argv[1], tell, 10)
rclpy.spin(node)
