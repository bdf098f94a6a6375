"""Compilation of MJCF by MuJoCo in a separate process: its input, output and their meaning."""
