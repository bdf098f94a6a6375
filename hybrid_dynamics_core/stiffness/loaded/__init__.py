"""Stiffness of a robot that bears loads: forces act on levers that turn as it gives way."""
