"""Algebra over any scalar: floats, NumPy arrays (one array a scalar) and traced symbols.

The same text runs on all of them. The order of its operations is part of its results: a trace keeps
it, and exact derivatives are summed in it.
"""
