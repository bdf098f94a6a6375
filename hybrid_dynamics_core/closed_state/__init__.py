"""From active coordinates to a closed state: solving, following, assembly modes, and why a loop does not close."""
