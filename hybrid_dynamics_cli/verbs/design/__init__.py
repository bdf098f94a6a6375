"""Verbs that choose numbers of a robot: drives of a catalogue."""
