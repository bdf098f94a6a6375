"""Studies over many designs."""
