"""A headless browser for tests and pictures of the 3D view.

python tools/browser.py

The command puts Chromium from the npm registry beside this Python, once. It needs npm, and the
Python package playwright. WebGL runs in software (SwiftShader): no graphics card and no display is
needed.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Page

VERSION = "147.0.0"
# Chromium's headless shell with SwiftShader, packed with Brotli.
PACKAGE = f"@sparticuz/chromium@{VERSION}"
PLACE = Path(sys.prefix) / "share" / "hybrid_dynamics" / f"chromium-{VERSION}"
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
PATIENCE = 300.0  # [s] for 70 MB
VARIABLE = "HYBRID_DYNAMICS_BROWSER"  # path of a Chromium that is to be used
SOFTWARE = (
    "--no-sandbox",  # inside containers; only our own page is opened
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--in-process-gpu",  # else frames pile up, and a picture of the page waits for them
)
DECOMPRESS = """\
const z = require('zlib'), fs = require('fs');
const [from, to] = JSON.parse(process.argv[1]);
fs.writeFileSync(to, z.brotliDecompressSync(fs.readFileSync(from)));
"""


class NoBrowserError(RuntimeError):
    """No browser is to be had; the text says why."""


def find_browser() -> str:
    """Path of a Chromium.

    Raises:
        NoBrowserError: there is none.
    """
    given = os.environ.get(VARIABLE)
    if given:
        return given
    if (PLACE / "chromium").exists():
        return str(PLACE / "chromium")
    for name in NAMES:
        if path := shutil.which(name):
            return path
    raise NoBrowserError(
        f"no Chromium: install one, name it in {VARIABLE}, or run python tools/browser.py"
    )


@contextmanager
def opened_page(url: str, width: int, height: int) -> Iterator[Page]:
    """The page of a viewer in a headless browser, once the scene has a canvas.

    Args:
        url: of the viewer.
        width: of the window, in pixels.
        height: of the window, in pixels.

    Raises:
        NoBrowserError: there is no browser, or it does not start.
    """
    try:
        # A tool of the tests.
        from playwright.sync_api import Error, sync_playwright  # noqa: PLC0415
    except ImportError as error:
        raise NoBrowserError(f"the Python package playwright is not installed ({error})") from error
    browser = find_browser()
    with sync_playwright() as driver:
        try:
            chromium = driver.chromium.launch(executable_path=browser, args=list(SOFTWARE))
        except Error as error:
            raise NoBrowserError(f"{browser} does not start: {error}") from error
        page = chromium.new_page(viewport={"width": width, "height": height}, locale="en-US")
        page.goto(url)
        page.wait_for_selector("canvas")
        # viser's notice about rendering without a card.
        notice = page.locator("#webgl-software-rendering button")
        notice.first.click()
        yield page
        chromium.close()


def install(folder: Path) -> None:
    """Unpack Chromium from the npm registry into a folder.

    Raises:
        NoBrowserError: npm is not installed.
    """
    if (folder / "chromium").exists():
        return
    npm = shutil.which("npm")
    if npm is None:
        raise NoBrowserError("npm is not installed, which would bring Chromium")
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as aside:
        pack = [npm, "pack", "--silent", "--fetch-retries=1", PACKAGE]
        subprocess.run(pack, cwd=aside, check=True, stdout=subprocess.DEVNULL, timeout=PATIENCE)
        packed = next(Path(aside).glob("*.tgz"))
        with tarfile.open(packed) as archive:
            # Python 3.11.2 and older have no filters
            archive.extraction_filter = getattr(tarfile, "data_filter", None)
            archive.extractall(aside)  # noqa: S202  npm checked its digest
        _unpack(Path(aside) / "package" / "bin", folder)


def _unpack(source: Path, folder: Path) -> None:
    """Brotli by Node, which playwright brings with it."""
    # It has no public name.
    from playwright._impl._driver import compute_driver_executable  # noqa: PLC0415

    node = compute_driver_executable()[0]
    for name in ("swiftshader.tar", "chromium"):
        target = source / name
        paths = json.dumps([f"{target}.br", str(target)])
        subprocess.run([node, "-e", DECOMPRESS, paths], check=True)
    with tarfile.open(source / "swiftshader.tar") as archive:
        # Python 3.11.2 and older have no filters
        archive.extraction_filter = getattr(tarfile, "data_filter", None)
        archive.extractall(folder)  # noqa: S202  of the same package
    (source / "chromium").chmod(0o755)
    (source / "chromium").replace(folder / "chromium")  # last: it says that all is there


if __name__ == "__main__":
    if len(sys.argv) != 1:
        sys.exit(__doc__)
    try:
        install(PLACE)
    except (ImportError, NoBrowserError, OSError, subprocess.SubprocessError) as problem:
        sys.exit(f"no browser: {problem}")
