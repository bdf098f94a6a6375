"""A robot's model as a C99 library: its programs traced, and written as source."""
