"""The demo plays the paper's trajectory into the running node, and shows, records and draws it.

python -m hybrid_dynamics_ros.demo --help
"""
