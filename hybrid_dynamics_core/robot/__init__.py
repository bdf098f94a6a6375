"""The class `Robot` and its parts."""
