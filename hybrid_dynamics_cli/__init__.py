"""The command `hybrid-dynamics`, with one verb for each task."""
