"""Errors of the demo, in words for the terminal."""


class DemoError(Exception):
    """The demo cannot go on; the text says why and what to do."""


class InterruptedDemoError(DemoError):
    """Someone asked the demo to stop."""
