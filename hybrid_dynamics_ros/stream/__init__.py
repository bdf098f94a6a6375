"""From a joint state to its results: the pipeline of the live node. Knows no rclpy."""
