"""Derivatives of graphs: slopes of single nodes, and their accumulation."""
