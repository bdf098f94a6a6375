"""The verbs of `hybrid-dynamics bag`, one module each."""
