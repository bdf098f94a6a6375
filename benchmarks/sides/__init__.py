"""One module a side, whose `sides(robot)` gives what takes part.

Importing it fails where its engine is not installed.
"""
