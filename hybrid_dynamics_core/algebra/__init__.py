"""Algebra over any scalar: floats, NumPy arrays (one array a scalar) and traced symbols.

The same code runs on all of them. The order of operations is fixed, since rounding depends on it. A
trace keeps that order.
"""
