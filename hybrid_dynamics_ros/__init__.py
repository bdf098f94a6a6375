"""ROS 2 node for hybrid robots: full state, efforts and end-effector pose from the active joints."""
