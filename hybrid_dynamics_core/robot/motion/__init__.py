"""Equations of motion for integrators: slopes near a state, and whole steps in compiled code."""
