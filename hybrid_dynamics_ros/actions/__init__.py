"""Actions of the node: long conversions, and a proxy in front of a trajectory controller."""
