"""Verbs that say what recordings of sensors show: the mass of a load, and joint states."""
