"""Processing of bags: the node's pipeline on whole recordings, without a ROS installation."""
