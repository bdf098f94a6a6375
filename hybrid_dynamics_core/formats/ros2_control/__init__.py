"""A robot's model as plugins of ros2_control: a package around its C code."""
