"""Block solvers: each closes a few loops, in closed form or by iteration."""
