"""Signal handlers that serve once: the same signal ends the process where Python does not run."""

from __future__ import annotations

import ctypes
import signal
from typing import Final

_IGNORE: Final = 1  # SIG_IGN


class OneShotHandler:
    """The handler that a signal has, put there for one time after the other.

    A handler in Python runs between two steps of the interpreter. While a call outside Python hangs
    it never does, and the signal would be lost. Used once, it leaves the next signal its default
    action: the end of the process.
    """

    def __init__(self, number: int) -> None:
        """Take the handler that is installed for a signal, and put it there for one time."""
        self._number = number
        library = ctypes.CDLL(None)
        self._install = getattr(library, "sysv_signal", None)  # of glibc alone
        if self._install is None:
            return
        self._install.restype = ctypes.c_void_p
        self._install.argtypes = [ctypes.c_int, ctypes.c_void_p]
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {number})
        self._handler = self._install(number, _IGNORE)
        self.arm()
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def arm(self) -> None:
        """Put the handler there for one time more."""
        if self._install is not None:
            self._install(self._number, self._handler)
