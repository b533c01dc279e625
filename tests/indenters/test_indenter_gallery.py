"""The picture of the indenters."""

import cv2
import numpy as np
import pytest

from tactiledata.indenters import INDENTERS, make_indenter


def test_gallery_shows_solids_the_same_every_time(tmp_path):
    """The picture has as many dark footprints as solids, and the same bytes each time."""
    pytest.importorskip("matplotlib")
    from tactiledata.indenters.gallery import draw_gallery

    solids = {name: INDENTERS[name]() for name in ("box", "ring")}
    draw_gallery(tmp_path / "a.png", solids)
    draw_gallery(tmp_path / "b.png", solids)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    image = cv2.imread(str(tmp_path / "a.png"))
    n_dark = cv2.connectedComponentsWithStats((image.max(axis=2) < 8).astype(np.uint8))[2][1:, cv2.CC_STAT_AREA]
    assert (n_dark > 2000).sum() == len(solids) + 1  # the ring has a dark middle


def test_every_solid_has_a_title_and_documented_sizes():
    """What a person reads about a solid names its sizes, and the guide names them all."""
    from pathlib import Path

    guide = (Path(__file__).parents[2] / "docs" / "indenters.md").read_text(encoding="utf-8")
    for name in INDENTERS:
        solid = make_indenter({"shape": name}, None, "test")
        assert solid.title
        assert f"`{name}`" in guide
        for size, value in solid.sizes.items():
            assert f"`{size}` {value:g}" in guide, f"docs/indenters.md lacks `{size}` {value:g} of {name}"
