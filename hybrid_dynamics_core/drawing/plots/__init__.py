"""Pages with axes: figures of a robot, of a simulation, and what they share."""
