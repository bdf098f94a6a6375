"""For tests: prints what is on /tf, in a process of its own: a line of JSON for each message."""

import json
import sys

import rclpy
from tf2_msgs.msg import TFMessage


def numbers(vector):
    return [getattr(vector, name) for name in vector.get_fields_and_field_types()]


def tell(message):
    rows = []
    for entry in message.transforms:
        frames = [entry.header.frame_id, entry.child_frame_id]
        transform = entry.transform
        rows.append([*frames, numbers(transform.translation), numbers(transform.rotation)])
    stamp = message.transforms[0].header.stamp
    line = {"stamp": stamp.sec * 10**9 + stamp.nanosec, "rows": rows}
    sys.stdout.write(f"{json.dumps(line)}\n")
    sys.stdout.flush()


rclpy.init()
node = rclpy.create_node("listener")
node.create_subscription(TFMessage, "/tf", tell, 1000)
rclpy.spin(node)
