"""Scalar-agnostic algebra: the same text runs on floats, on NumPy arrays (one array a scalar) and on traced symbols."""
