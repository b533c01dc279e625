"""A zero of each component as a parameter, so that a bias that drifts is told from a modulus that does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactiledata.diagnose.residuals import Parameter, Residuals


def with_zeros(residuals: Residuals) -> Residuals:
    """Residuals that know a zero of each component beside their parameters, in the component's unit."""
    width = len(residuals.components)
    deviations = np.ones(width) if residuals.deviations is None else residuals.deviations
    units = residuals.units or ("times the noise",) * width
    slopes = np.broadcast_to(np.diag(1.0 / deviations), (len(residuals.values), width, width))
    zeros = tuple(Parameter(f"zero of {name}", unit) for name, unit in zip(residuals.components, units, strict=True))
    return replace(
        residuals,
        parameters=(*residuals.parameters, *zeros),
        sensitivities=np.concatenate([residuals.slopes, slopes], axis=2),
    )
