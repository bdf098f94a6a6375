"""Estimation of velocities and accelerations from sampled positions."""
