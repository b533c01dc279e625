"""Drawing of figures whose texts come from recordings, in any script, without warnings of it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDE_FONTS = (
    "Noto Sans CJK SC", "Noto Sans CJK JP", "Noto Sans SC", "Noto Sans JP", "Source Han Sans SC", "WenQuanYi Micro Hei",
    "WenQuanYi Zen Hei", "Droid Sans Fallback", "PingFang SC", "Hiragino Sans GB", "Hiragino Sans", "Microsoft YaHei",
    "SimHei", "Arial Unicode MS", "Noto Sans", "Unifont",
)  # fmt: skip
"""Fonts with scripts that matplotlib's own lacks; those that a machine has are asked for such signs, in this order."""


@contextmanager
def drawing(figure: Figure) -> Iterator[None]:
    """Let the block draw a figure: signs that no font has become boxes, of which nothing is said on the terminal.

    Parameters
    ----------
    figure : Figure
        Its texts fall back to fonts of other scripts, where the machine has some.
    """
    from matplotlib.font_manager import fontManager
    from matplotlib.text import Text

    known = set(fontManager.get_font_names())
    more = [name for name in WIDE_FONTS if name in known]
    for text in figure.findobj(Text) if more else ():
        text.set_fontfamily([*(one for one in text.get_fontfamily() if one not in more), *more])
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph .* missing from font", UserWarning)
        yield
