"""One module a side: `sides(robot)` gives what it brings; importing it fails where its engine is not installed."""
