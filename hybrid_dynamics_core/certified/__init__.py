"""Proofs by computation: enclosures in outward rounding, and lists of all solutions.

What counts as proved, and under which assumptions, is explained in docs/certified.md.
"""
