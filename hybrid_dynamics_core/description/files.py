"""Text files, read with the refusals that every reader needs: too large, not there, not UTF-8."""

from __future__ import annotations

from pathlib import Path

from ..errors import DescriptionError

MAX_BYTES = 5_000_000


def read_text(path: Path) -> str:
    """The text of a file.

    Raises:
        DescriptionError: it cannot be read, or is no text of the size of a description.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise DescriptionError(
                f"larger than {MAX_BYTES} bytes; not a robot description", file=path
            )
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise DescriptionError(f"not UTF-8 text (byte {error.start})", file=path) from error
    except OSError as error:
        raise DescriptionError(f"cannot be read: {error.strerror or error}", file=path) from error
