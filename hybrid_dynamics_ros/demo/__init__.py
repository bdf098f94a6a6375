"""The demo: the paper's trajectory goes from a recording into the running node.

The results are shown, recorded and drawn.

python -m hybrid_dynamics_ros.demo --help
"""
