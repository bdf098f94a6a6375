"""Verbs of studies: what happens when the numbers of a robot vary."""
