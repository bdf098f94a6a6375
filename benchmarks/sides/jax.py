"""JAX, compiled by XLA from the program of this library."""

from __future__ import annotations

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np

from hybrid_dynamics_core import Robot

from ..side import Side
from .our_text import inverse_dynamics

Array = np.ndarray


def sides(robot: Robot) -> list[Side]:
    """The jit of one state, and of vmap for a batch."""
    jax.config.update("jax_enable_x64", True)
    functions = SimpleNamespace(
        sin=jnp.sin,
        cos=jnp.cos,
        sqrt=jnp.sqrt,
        fabs=jnp.abs,
        floor=jnp.floor,
        atan2=jnp.arctan2,
    )
    text = inverse_dynamics(robot, functions)

    def tau(u: jax.Array, du: jax.Array, ddu: jax.Array) -> jax.Array:
        return jnp.stack(text(u, du, ddu))

    single = jax.jit(tau)
    mapped = jax.jit(jax.vmap(tau))

    def call(u: Array, du: Array, ddu: Array) -> Array:
        return np.asarray(single(u, du, ddu))

    def batch(u: Array, du: Array, ddu: Array) -> Array:
        return np.asarray(mapped(u, du, ddu))

    return [Side("JAX jit", {"id": call, "id_batch": batch})]
