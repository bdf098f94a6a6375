"""The section `stiffness` of a description file."""
