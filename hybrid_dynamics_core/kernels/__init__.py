"""Programs traced once per robot into straight-line code, and run from there."""
