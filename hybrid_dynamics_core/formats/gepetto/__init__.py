"""Gepetto's pair: a robot.yaml with closed_loop pairs beside a URDF."""
