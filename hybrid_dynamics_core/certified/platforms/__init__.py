"""All poses of platforms in space, by homotopies with certified ends."""
