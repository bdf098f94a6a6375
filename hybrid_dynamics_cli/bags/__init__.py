"""The verbs of `hybrid-dynamics bag`, a module each."""
