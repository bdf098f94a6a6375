"""Messages as data: their layouts, what is read from them and written into them. Knows no rclpy."""
