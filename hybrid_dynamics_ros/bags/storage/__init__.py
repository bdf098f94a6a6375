"""Bags as files: reading and writing MCAP and SQLite."""
