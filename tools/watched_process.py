"""Long programs whose output goes to a file, and which say from time to time what they do."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from textwrap import fill, shorten

WIDTH = 80  # letters of a terminal
HEARTBEAT = 15.0  # [s] between signs of life of a long step


class Process:
    """Programs, of which each is for the failure of the one before.

    Their output goes to a file, and their temporary files to a folder of their own.
    """

    def __init__(self, commands: list[list[str]], log: Path, settings: dict[str, str]) -> None:
        """Begin the first.

        Args:
            commands: programs with their arguments.
            log: the file of the output.
            settings: environment variables.
        """
        self.log, self._settings = log, settings
        self._commands = list(commands)
        self.scratch = tempfile.mkdtemp(prefix="hybrid_dynamics_setup-")
        self.start = time.monotonic()
        self._begin_next()

    def _begin_next(self) -> None:
        self.command = self._commands.pop(0)
        with self.log.open("w", encoding="utf-8") as output:
            self._process = subprocess.Popen(
                self.command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**self._settings, "TMPDIR": self.scratch},
            )

    def stop(self) -> None:
        """End it, unless it has ended."""
        self._process.terminate()

    def finish(self, title: str) -> None:
        """Wait for the end, and say from time to time what the program does.

        Raises:
            SystemExit: the last one failed; the text has its last lines.
        """
        print(fill(f"{title} ...", WIDTH, subsequent_indent="  "), flush=True)
        try:
            code = self._watch()
            while code != 0 and self._commands:
                print(
                    f"  this failed, so another way is tried: {' '.join(self.command)}", flush=True
                )
                self._begin_next()
                code = self._watch()
        finally:
            discard(self.scratch)
        if code != 0:
            sys.exit(
                f"{last_lines(self.log, 30)}\nThis failed: {' '.join(self.command)}\n"
                f"All it said is in {self.log}"
            )

    def _watch(self) -> int:
        previous = ""
        while True:
            try:
                return self._process.wait(HEARTBEAT)
            except subprocess.TimeoutExpired:
                line = last_lines(self.log, 1)
                news = shorten(line, WIDTH - 10)
                if line == previous:
                    news = "at work, and has said nothing new"
                print(f"  {time.monotonic() - self.start:4.0f} s  {news}", flush=True)
                previous = line


def discard(scratch: str) -> None:
    """Remove a folder with many files, beside what follows."""
    remove = "import shutil, sys; shutil.rmtree(sys.argv[1], ignore_errors=True)"
    subprocess.Popen(
        [sys.executable, "-c", remove, scratch], stdin=subprocess.DEVNULL, start_new_session=True
    )


def last_lines(log: Path, count: int) -> str:
    """The last lines of a log that say something."""
    text = log.read_text(encoding="utf-8", errors="replace")
    lines = [line.strip() for line in text.splitlines()]
    return "\n".join([line for line in lines if line and not line.startswith("WARNING")][-count:])
