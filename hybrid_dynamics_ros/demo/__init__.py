"""The demo: the paper's trajectory, played from a recording into the running node, shown, recorded and drawn.

python -m hybrid_dynamics_ros.demo --help
"""
