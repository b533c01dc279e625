"""Adaptive instance normalisation (AdaIN): features take mean and spread of another sensor's, channel by channel."""

from __future__ import annotations

import torch

from tactiledata.errors import UsageError

LEAST_VARIANCE = 1e-5
"""Amount that is added to variances before the root, as in the source, so that constant channels stay finite."""


def adaptive_instance_norm(content: torch.Tensor, style: torch.Tensor) -> torch.Tensor:
    """Content features with the style's mean and standard deviation over the plane, channel by channel.

    Parameters
    ----------
    content : (n, C, H, W)
        Features of touches.
    style : (n or 1, C, h, w)
        Features of pictures in the desired style; the plane may have another size.

    Returns
    -------
    (n, C, H, W)

    Raises
    ------
    UsageError
        The shapes do not fit each other.

    Source
    ------
    Huang and Belongie, Arbitrary Style Transfer in Real-time with Adaptive Instance Normalization, ICCV 2017, eq. 8
    """
    fits = content.ndim == style.ndim == 4 and content.shape[1] == style.shape[1]
    if not fits or style.shape[0] not in (1, content.shape[0]):
        raise UsageError(
            f"content of shape {tuple(content.shape)} with style of shape {tuple(style.shape)}",
            "(n, C, H, W) and (n or 1, C, h, w)",
        )
    mean, spread = _statistics(content)
    goal_mean, goal_spread = _statistics(style)
    return (content - mean) / spread * goal_spread + goal_mean


def _statistics(features: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Mean and standard deviation (n, C, 1, 1) over the plane."""
    variance, mean = torch.var_mean(features, dim=(2, 3), keepdim=True, correction=0)
    return mean, (variance + LEAST_VARIANCE).sqrt()
