"""Tracing, compilation and calls of programs: straight-line code for each robot."""
