"""MuJoCo compiles a file in a process of its own: what it gets, what it says, what it means."""
