"""ROS 2 node for hybrid robots.

Full state, efforts and end-effector pose from the active joints.
"""
