"""Recordings: the node's pipeline on whole bags, without a ROS installation."""
