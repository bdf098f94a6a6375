"""All tests.

Workers of pytest-xdist share the processors: each takes one thread of BLAS, and so do its children.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when NumPy is first imported
