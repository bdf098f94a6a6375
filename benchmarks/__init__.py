"""How fast the kernels are, beside every other engine that is installed: `python -m benchmarks`.

Each side does the same work on the forging robot as well as a good user of that engine would, and
the answers are compared before anything is timed.
"""
