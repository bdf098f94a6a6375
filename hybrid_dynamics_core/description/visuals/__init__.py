"""Shapes by which pictures show links: out of the entries of a document."""
