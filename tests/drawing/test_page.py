"""The frame of plots: a heading, axes, and a caption, close together and apart."""

import pytest

from hybrid_dynamics_core.drawing.page import page

CAPTION = "What was assumed, in as many words as it takes to fill some lines of the page. " * 3


@pytest.mark.parametrize("line", ["", "what is shown"])
@pytest.mark.parametrize("caption", ["", CAPTION])
def test_axes_fill_the_room_between_heading_and_caption(line: str, caption: str) -> None:
    figure = page("Title", caption, line=line)
    axes = figure.subplots()
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in figure.texts]
    top = min(box.y0 for box in boxes if box.y0 > axes.bbox.y0)
    assert 0.0 < top - axes.bbox.y1 < 0.3 * figure.dpi
    low = axes.get_tightbbox().y0
    bottom = max((box.y1 for box in boxes if box.y1 < axes.bbox.y1), default=0.0)
    assert 0.0 < low - bottom < 0.3 * figure.dpi
