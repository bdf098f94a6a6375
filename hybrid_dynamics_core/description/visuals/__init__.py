"""Visuals of links, from the entries of a document."""
