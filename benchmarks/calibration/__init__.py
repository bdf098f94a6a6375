"""Accuracy of calibration on simulated measurements."""
