"""A robot's model as Functional Mock-up Units of FMI 3.0 and 2.0, around its C code."""
