"""The pipeline from joint states to results. It does not depend on rclpy."""
