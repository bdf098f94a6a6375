"""The demo: it plays the paper's trajectory from a recording into the running node.

It shows, records and draws the results.

python -m hybrid_dynamics_ros.demo --help
"""
