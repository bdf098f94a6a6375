"""Messages as data: layouts, reading and writing. It does not depend on rclpy."""
