"""Errors of the demo, with texts for the terminal."""


class DemoError(Exception):
    """The demo failed; the text says why and what to do."""


class InterruptedDemoError(DemoError):
    """The demo was interrupted."""
