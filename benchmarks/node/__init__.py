"""Latency and losses of the node, beside a node that only echoes: `python -m benchmarks.node`."""
