"""Chains, modules, legs and loops of a description become links, joints and closures."""
