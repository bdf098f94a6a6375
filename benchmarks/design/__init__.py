"""CPU time of a design."""
