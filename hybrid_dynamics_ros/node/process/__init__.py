"""The node's process: signals, and a watchdog."""
