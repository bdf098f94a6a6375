"""Reading of text files, with errors for files that are too large, missing or not UTF-8."""

from __future__ import annotations

from pathlib import Path

from ..errors import DescriptionError
from ..ground.regular_files import read_regular

MAX_BYTES = 5_000_000


def read_text(path: Path) -> str:
    """The text of a file.

    Raises:
        DescriptionError: the file cannot be read, is no text, or is too large for a description.
    """
    try:
        data = read_regular(path, MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise DescriptionError(
                f"larger than {MAX_BYTES} bytes; not a robot description", file=path
            )
        return data.decode("utf-8").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise DescriptionError(f"not UTF-8 text (byte {error.start})", file=path) from error
    except OSError as error:
        raise DescriptionError(f"cannot be read: {error.strerror or error}", file=path) from error
