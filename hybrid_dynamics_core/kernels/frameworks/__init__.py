"""Traces as functions of other frameworks: JAX and CasADi, loaded only when they are used."""
