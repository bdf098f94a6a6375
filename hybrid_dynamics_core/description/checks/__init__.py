"""Checks of a description: schema, names, values, types of loops, plausible sizes."""
