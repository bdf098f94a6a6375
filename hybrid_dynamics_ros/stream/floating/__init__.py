"""Bases that move freely, and the charts of ball and free joints on topics."""
