"""Verbs of elastic robots: stiffness, deflections and natural frequencies."""
