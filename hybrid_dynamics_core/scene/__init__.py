"""The geometry of a picture: from a robot and a state to parts, marks and views, in two or three dimensions."""
