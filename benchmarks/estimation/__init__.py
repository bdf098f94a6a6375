"""Accuracy of weighing on simulated lifts."""
