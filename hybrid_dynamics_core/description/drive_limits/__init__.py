"""Limits of drives beyond one number: tables of efforts, and pumps."""
