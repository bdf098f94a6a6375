"""One-shot signal handlers: a second signal ends the process even if Python is blocked."""

from __future__ import annotations

import ctypes
import signal
from typing import Final

_IGNORE: Final = 1  # SIG_IGN


class OneShotHandler:
    """Installs the handler of a signal for one delivery at a time.

    A Python handler runs between two steps of the interpreter. While a call outside of Python
    hangs, it never runs, and the signal would be lost. A one-shot handler leaves the next signal
    its default action, which ends the process.
    """

    def __init__(self, number: int) -> None:
        """Take the installed handler of a signal, and install it for one delivery."""
        self._number = number
        library = ctypes.CDLL(None)
        self._install = getattr(library, "sysv_signal", None)  # glibc only
        if self._install is None:
            return
        self._install.restype = ctypes.c_void_p
        self._install.argtypes = [ctypes.c_int, ctypes.c_void_p]
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {number})
        self._handler = self._install(number, _IGNORE)
        self.arm()
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def arm(self) -> None:
        """Install the handler for one more delivery."""
        if self._install is not None:
            self._install(self._number, self._handler)
