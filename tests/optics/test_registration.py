"""Registration: planted views are found, mirrored ones told apart, and too little is refused with its reason."""

from functools import cache

import cv2
import numpy as np
import pytest
from known_surfaces import cap, flat_surface, pressed, view

from tactiledata.errors import TactileDataError, UsageError
from tactiledata.optics.height_map import Indentation, slopes
from tactiledata.optics.registration import Touch, register
from tactiledata.optics.view_search import move_field, moved_view

SHAPE = (160, 120)
PLANTED = np.array([2.5, -2.0, 1.5, -1.0, 1.2, -1.5])
"""px: shift and linear part."""


def three_lights(slope):
    """Change of colour under a red, a green and a blue light: Lambert's law, each from another side."""
    x, y = slope[..., 0], slope[..., 1]
    lit = [x, -0.5 * x + 0.9 * y, -0.5 * x - 0.9 * y]
    cosine = np.stack([(0.5 + side) / np.sqrt(1 + x * x + y * y) for side in lit], axis=-1)
    return 160 * (np.maximum(cosine, 0) - 0.5)


@cache
def touches(count, seed=0, reach=(3e-3, 4.5e-3), moves=tuple(PLANTED), mirrored=True):
    """Balls on a grey background, lit from three sides, seen through a view that was moved."""
    surface, truth = flat_surface(61, 83), moved_view(view(SHAPE, mirrored), np.array(moves))
    drawn, rng = Indentation(surface, truth), np.random.default_rng(seed)
    background = np.full((*SHAPE, 3), 110, np.uint8)
    made = []
    for _ in range(count):
        moved = pressed(surface, cap(3e-3, rng.uniform(4e-4, 9e-4), rng.uniform(-1, 1, 2) * reach))
        change = three_lights(slopes(cv2.GaussianBlur(drawn.of(moved), (0, 0), 1.5), truth))
        noisy = background + change + rng.normal(0, 1.5, change.shape)
        made.append(Touch(np.clip(noisy, 0, 255).astype(np.uint8), background, moved))
    return surface, truth, made


def true_error(found, truth):
    """Root mean square, px, over the picture."""
    return float(np.sqrt(np.square(move_field(found, truth)).sum(-1).mean()))


@pytest.mark.slow
def test_a_planted_affine_view_is_found():
    """A view 3.5 px away is found to well under a pixel, and the error that it states is of that order."""
    surface, truth, made = touches(10)
    found = register(surface, made, view(SHAPE), "affine", try_mirror=False)
    assert true_error(view(SHAPE), truth) > 3
    assert true_error(found.view, truth) < 0.8
    assert found.error < 1.2
    assert found.moved == pytest.approx(true_error(view(SHAPE), truth), abs=0.8)
    assert found.unexplained < 0.1
    assert found.touches == 10


@pytest.mark.slow
def test_a_planted_shift_is_found_whichever_way_the_picture_is_mirrored():
    """Started from the wrong mirror image, the right one is taken; the other explains far less."""
    for mirrored in (True, False):
        surface, truth, made = touches(3, moves=(2.0, -3.0), mirrored=mirrored)
        found = register(surface, made, view(SHAPE), "shift")
        assert found.view.is_mirrored is mirrored
        assert true_error(found.view, truth) < 0.7
        assert found.mirror_ratio < 0.7


def test_a_view_that_is_right_stays_where_it_is():
    """A view that is right is not moved."""
    surface, truth, made = touches(3, moves=(0.0, 0.0))
    found = register(surface, made, truth, "shift", try_mirror=False)
    assert found.moved < 0.4


@pytest.mark.slow
def test_too_few_touches_are_refused():
    """Five do not make an affine view; untouched pictures do not count."""
    surface, _, made = touches(10)
    with pytest.raises(TactileDataError, match="5 of 5 touches"):
        register(surface, made[:5], view(SHAPE))
    blank = [Touch(touch.background, touch.background, touch.displacement) for touch in made]
    with pytest.raises(TactileDataError, match="0 of 10 touches"):
        register(surface, blank, view(SHAPE))
    still = [Touch(touch.picture, touch.background, np.zeros_like(touch.displacement)) for touch in made]
    with pytest.raises(TactileDataError, match="0 of 10 touches"):
        register(surface, still, view(SHAPE))


def test_touches_on_a_spot_are_refused():
    """They tell a shift, not a scale."""
    surface, _, made = touches(7, reach=(2e-4, 4e-3))
    with pytest.raises(TactileDataError, match="spot or a line"):
        register(surface, made, view(SHAPE))


def test_a_mirror_image_that_fits_as_well_is_refused():
    """Balls along the middle line look the same in the mirror."""
    surface, _, made = touches(2, reach=(0.0, 3e-3), moves=(0.0, 0.0))
    colourless = [
        Touch(np.repeat(touch.picture.mean(axis=2, keepdims=True), 3, axis=2).astype(np.uint8), *rest(touch))
        for touch in made
    ]
    both = [
        Touch((touch.picture // 2 + touch.picture[:, ::-1] // 2).astype(np.uint8), *rest(touch)) for touch in colourless
    ]
    with pytest.raises(TactileDataError, match="mirror image"):
        register(surface, both, view(SHAPE), "shift")


def rest(touch):
    return touch.background, touch.displacement


def test_wrong_calls():
    """Pictures of two sizes, a kind that is none."""
    surface, _, made = touches(3, moves=(0.0, 0.0))
    with pytest.raises(UsageError, match="kind"):
        register(surface, made, view(SHAPE), "rigid")
    small = Touch(made[0].picture[:80], made[0].background[:80], made[0].displacement)
    with pytest.raises(UsageError, match="one shape"):
        register(surface, [*made, small], view(SHAPE))
