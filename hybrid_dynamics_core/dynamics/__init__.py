"""Rigid-body kinematics and dynamics over the spanning tree, and their minimal form by projection."""
