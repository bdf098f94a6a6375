"""Closed kinematics: poses, workspaces, inverse kinematics."""
