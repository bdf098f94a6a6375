"""The calls of a robot in other frameworks: pure functions of JAX, Functions of CasADi."""
