"""Coordinates in which a motion is integrated: the robot's, and others through singular places."""
