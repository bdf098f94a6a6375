"""Rigid-body kinematics and dynamics over the spanning tree.

The programs project them onto the active coordinates.
"""
