"""Playing of a recording into the node, and recording of its output."""
