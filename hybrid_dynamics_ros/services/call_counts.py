"""Statistics of service calls, for diagnostics."""

from __future__ import annotations

import threading
from collections import Counter
from typing import Final

from hybrid_dynamics_msgs.msg import ErrorCode

from ..stream.monitor import Level, StatusEntry

_NAMES: Final = {getattr(ErrorCode, name): name for name in vars(type(ErrorCode)) if name.isupper()}
_OURS: Final = (ErrorCode.BUSY, ErrorCode.TIMEOUT, ErrorCode.INTERNAL)  # not caused by the request


class CallCounts:
    """Counts answers, from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._answers: Counter[tuple[str, int]] = Counter()
        self._unserved = 0  # value at the last report
        self._last_error = "none"

    def note(self, service: str, code: int, text: str) -> None:
        """Register the response of a call.

        Args:
            service: name of the service.
            code: ErrorCode of the response.
            text: error text.
        """
        with self._lock:
            self._answers[service, code] += 1
            if code != ErrorCode.OK:
                self._last_error = f"{service}: {text}"

    def report(self) -> list[StatusEntry]:
        """Numbers of responses by service and code since the start.

        It warns if calls since the last report were not served: BUSY, TIMEOUT or INTERNAL.
        """
        with self._lock:
            answers, last = dict(self._answers), self._last_error
        unserved = sum(count for (_, code), count in answers.items() if code in _OURS)
        recent, self._unserved = unserved - self._unserved, unserved
        level = Level.WARN if recent else Level.OK
        entries = [
            StatusEntry("calls answered", str(sum(answers.values()))),
            StatusEntry("not served since last report", str(recent), level),
        ]
        for service in dict.fromkeys(name for name, _ in answers):
            parts = [
                f"{count} {_NAMES.get(code, code)}"
                for (name, code), count in answers.items()
                if name == service
            ]
            entries.append(StatusEntry(service, ", ".join(parts)))
        return [*entries, StatusEntry("last error", last)]
