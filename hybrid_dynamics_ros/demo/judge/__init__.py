"""Evaluation of the demo's results: comparison and figures."""
