"""AdaIN: the result has the style's statistics and the content's pattern."""

import pytest
import torch

from split_models.transfer.adaptive_instance_norm import adaptive_instance_norm
from tactiledata.errors import UsageError


@pytest.fixture
def features():
    torch.manual_seed(0)
    return torch.randn(4, 5, 8, 6) * 3 + 1, torch.randn(1, 5, 10, 4) * 0.5 - 2


def test_statistics_are_the_styles(features):
    """Mean and standard deviation of every channel are the style's."""
    content, style = features
    moved = adaptive_instance_norm(content, style)
    torch.testing.assert_close(moved.mean((2, 3)), style.mean((2, 3)).expand(4, -1), atol=1e-4, rtol=1e-4)
    goal = style.std((2, 3), correction=0).expand(4, -1)
    torch.testing.assert_close(moved.std((2, 3), correction=0), goal, atol=1e-3, rtol=1e-3)


def test_own_style_changes_nothing(features):
    """Content as its own style stays as it is."""
    content, _ = features
    torch.testing.assert_close(adaptive_instance_norm(content, content), content, atol=1e-4, rtol=1e-4)


def test_content_counts_up_to_gain_and_offset(features):
    """A gain and an offset of the content's channels, which are style, do not change the result."""
    content, style = features
    gain, offset = torch.rand(1, 5, 1, 1) + 0.5, torch.randn(1, 5, 1, 1)
    once, other = adaptive_instance_norm(content, style), adaptive_instance_norm(content * gain + offset, style)
    torch.testing.assert_close(once, other, atol=1e-3, rtol=1e-3)


def test_constant_channels_stay_finite():
    """A channel without spread becomes the style's mean."""
    moved = adaptive_instance_norm(torch.ones(1, 2, 4, 4), torch.rand(1, 2, 4, 4))
    assert torch.isfinite(moved).all()


@pytest.mark.parametrize("shape", [(2, 5, 4, 4), (1, 3, 4, 4), (5, 4, 4)])
def test_shapes_that_do_not_fit_are_refused(features, shape):
    """Another number of channels, or several styles that are not one a content."""
    with pytest.raises(UsageError, match="style of shape"):
        adaptive_instance_norm(features[0], torch.zeros(shape))
