"""Loop-closure equations: what a closure, a mimic or a leg demands of the coordinates."""
