"""Loop-closure equations of closures, mimic joints and legs."""
