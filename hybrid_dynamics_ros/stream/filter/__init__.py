"""Rates and accelerations from sampled positions."""
