"""All poses of planar platforms, by roots of resultants in discs of their own."""
