"""The process of the node: signals, and what ends it where it hangs."""
