"""python -m hybrid_dynamics_ros.node."""

import sys

from .entry import main

sys.exit(main())
