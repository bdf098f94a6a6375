"""python -m hybrid_dynamics_ros.demo."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
