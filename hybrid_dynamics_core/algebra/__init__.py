"""Algebra over any scalar: floats, NumPy arrays (one array a scalar) and traced symbols.

The same text runs on all of them.
"""
