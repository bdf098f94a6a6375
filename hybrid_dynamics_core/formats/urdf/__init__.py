"""URDF, and URDF+ with its loops."""
