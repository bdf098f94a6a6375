"""Correction of loops whose redundant equations fit only up to the printed digits of a file."""
