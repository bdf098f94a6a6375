"""The geometry of a picture: from a robot and a state to parts, lines and a projection."""
