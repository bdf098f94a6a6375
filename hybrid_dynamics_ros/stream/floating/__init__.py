"""Floating bases, and charts of ball and free joints in messages."""
