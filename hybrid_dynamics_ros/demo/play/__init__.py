"""Playing a recording into the node, and recording what it answers."""
