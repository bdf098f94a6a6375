"""The robot as its users see it, and the parts that it is composed of."""
