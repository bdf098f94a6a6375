"""Scenes on Matplotlib's axes: parts, labels, legend, ground."""
