"""The geometry of pictures: parts, lines and a projection from a robot and a state."""
