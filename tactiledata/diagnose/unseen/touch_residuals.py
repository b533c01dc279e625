"""Residuals of a fit to recorded touches, in the form that locators, formulas and black box ask for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.gate import NoiseModel
from tactiledata.diagnose.locate.locate import LocateOptions, LocatorResults, locate
from tactiledata.diagnose.naming.error_sizes import estimated_sizes, typical_size
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.signatures import effect_signatures
from tactiledata.diagnose.residuals.residuals import Names, ResidualParameter, Residuals
from tactiledata.diagnose.residuals.sign_flips import DRAWS
from tactiledata.diagnose.touches.covariates import case_covariates, contacts, phases
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.effects import EFFECTS
from tactiledata.nuisance.offsets import PRIOR

OF_THE_GEL: Mapping[str, float] = {
    "fx": 0.0093, "fy": 0.0093, "fz": 0.0057, "tx": 0.27, "ty": 0.27, "tz": 0.05,
    "shear along the slide": 0.005, "torque of shear along the slide": 0.66,
    "E": 0.042, "nu": 0.022, "mu": 0.06, "contact offset": 0.01,
}  # fmt: skip
"""Standard deviations of contrasts where nothing is missing, for errors of the simulation of the usual size, in the
units of `contrast_units`. Other solvers of one gel gave them, in 20 worlds of sealed proofs that hide nothing: nine of
ten have less (``python benchmarks/proof_located.py twelfth thirteenth fourteenth --errors``)."""


def contrast_units(white: WhitenedTouches, fit: JointFit) -> dict[str, float]:
    """Return the unit of each contrast in which errors of all simulations are about as large.

    An error of a component of force or torque is a share of its root mean square in contact, which is given here in
    times the noise, as `Contrast.size` is. Errors of E, nu and mu are shares of their values, that of the contact
    offset is in mm. All are multiplied by the typical size of the simulation's errors beside the fit, 1 where they are
    as usual.

    Parameters
    ----------
    white : WhitenedTouches
    fit : JointFit
        The fit whose residuals are located.

    Returns
    -------
    dict, name of a component, direction or parameter -> float
    """
    size = typical_size(estimated_sizes(white, fit))
    cases, model = white.touch_set, fit.model
    wrench = cases.play(model.material, model.settings, model.offsets)
    in_contact = known_rows(white, wrench) & (np.linalg.norm(np.nan_to_num(wrench[:, :3]), axis=1) > LEAST_FORCE)
    squares = (wrench[in_contact] ** 2).mean(axis=0) if in_contact.any() else np.zeros(6)
    noise = np.mean([case.noise.deviations for case in cases.touches], axis=0)
    of_component = np.sqrt(squares) / noise
    shear = np.sqrt(squares[:2].sum()) / noise[:2].mean()
    torque = np.sqrt(squares[3:5].sum()) / noise[3:5].mean()
    units = dict(zip(COMPONENTS, of_component.tolist(), strict=True))
    units |= {"shear along the slide": float(shear), "torque of shear along the slide": float(torque)}
    units |= dict.fromkeys(("E", "nu", "mu", "contact offset"), 1.0)
    return {name: size * unit for name, unit in units.items()}


def scatter_beyond_noise(sizes: Array, variances: Array) -> float:
    """Return the standard deviation e by which c sizes scatter beyond the variances (c,) that noise gives them.

    A size is an estimated number, such as the contrast of one world, and noise gives each a variance of its own.

    It solves ``mean(sizes^2 / (variances + e^2)) = 1``: the sizes are taken to scatter about 0. It is 0 where noise
    alone explains the scatter, and has the unit of the sizes. Source: the moment estimator of a variance component
    (Paule and Mandel, J. Res. NBS 87, 1982).
    """

    def excess(e: float) -> float:
        return float(np.mean(sizes**2 / (variances + e**2))) - 1.0

    if not len(sizes) or excess(0.0) <= 0:
        return 0.0
    return float(brentq(excess, 0.0, float(np.abs(sizes).max())))


LEAST_FORCE = 0.05
"""N. A simulated frame with less force is not in contact."""
COMPONENTS = ("fx", "fy", "fz", "tx", "ty", "tz")
UNITS = ("N", "N", "N", "N mm", "N mm", "N mm")
TO_UNIT = np.array([1.0, 1.0, 1.0, 1e3, 1e3, 1e3])
"""Factors from N and N m to `UNITS`."""


def known_rows(white: WhitenedTouches, predicted: Array) -> NDArray[np.bool_]:
    """Return which of N frames (N,) have both a measured wrench and a predicted one.

    Parameters
    ----------
    white : WhitenedTouches
        Frames of all trajectories; one without a measured wrench has a weight of 0.
    predicted : (N, 6)
        Predicted wrenches, not a number where there is none.
    """
    return (white.weights > 0) & np.isfinite(predicted).all(axis=1)


def case_residuals(white: WhitenedTouches, fit: JointFit) -> Residuals:
    """Return the whitened residuals of a fit, without frames that were not measured or not simulated.

    - E, nu and mu are tested for drifts, except one at its bound.
    - Each trajectory's contact offset and zeros are marginalised under their priors.
    - Errors of the simulation itself and the numbers of effects are refitted with E, nu and mu and never tested: they
      are known to be uncertain.
    - Covariates of the contact, and ``contact`` ("stick" or "slip"), come from the plain simulation at the fitted gel.
    """
    # frames that are known, and slopes of the wrench over the parameters
    cases, model = white.touch_set, fit.model
    answers = contacts(cases, model.material, model.offsets)
    rows = known_rows(white, np.concatenate([answer.wrench for answer in answers]))
    single = _single(white)
    parameters, fields = _parameters(white, fit)
    # own unknowns become parameters: else whitening would spread what contact leaves into frames in free air
    slopes = white.with_own(np.stack(fields, axis=2))
    names = tuple(ResidualParameter(name, own_deviation=1.0, is_tested=False) for name in white.own.names())
    deviations = np.mean([case.noise.deviations for case in cases.touches], axis=0) * TO_UNIT
    # numbers with a prior move back to its mean
    beside = fit.residual + fit.own * fit.by_row + fit.simulation_error_fields @ model.errors
    return Residuals(
        white.with_own(beside) * single,
        COMPONENTS,
        white.trajectory.astype(np.int64),
        case_covariates(cases, answers),
        _labels(white, np.concatenate([answer.sliding for answer in answers])),
        (*parameters, *names),
        np.concatenate([slopes, white.own_fields], axis=2) * single[:, :, None],
        units=UNITS,
        deviations=deviations,
        ways=slide_ways(white),
    ).part(rows)


def slide_ways(white: WhitenedTouches) -> dict[str, Array]:
    """Return unit wrenches (N, 6) of shear along each trajectory's first slide and of its torque; 0 without a slide."""
    ways = np.zeros((len(white.trajectory), 2))
    for number, case in enumerate(white.touch_set.touches):
        steps = np.diff(np.nan_to_num(case.touch.tips[:, :2]), axis=0, prepend=np.nan_to_num(case.touch.tips[:1, :2]))
        first = steps[np.flatnonzero(phases(case) == "shear")[:1]].sum(axis=0)
        ways[white.trajectory == number] = first / max(float(np.hypot(*first)), 1e-300)
    force, torque = np.zeros((2, len(ways), 6))
    force[:, :2] = ways
    # a force along x at some height turns about y, one along y about -x
    torque[:, 3:5] = np.column_stack([-ways[:, 1], ways[:, 0]])
    return {"shear along the slide": force, "torque of shear along the slide": torque}


def signature_fields(white: WhitenedTouches, fit: JointFit, effects: Sequence[str]) -> dict[str, Array]:
    """Return what each effect changes in the n rows of `case_residuals`, as whitened changes (n, 6) of the wrench.

    Each change is that over one prior standard deviation of one strength, about the fit. Its key names the effect's
    title and the strength, and the values of the shape parameters where the effect has any:
    ``"viscoelastic relaxation (share, time 3)"``. A strength that acts from a threshold on is taken at several sizes,
    which the key names as well: ``"quantisation and dead-band (dead_band at 0.2 N, torque_noise 0.005)"``. Each choice
    of shapes and size has an entry of its own. A strength that changes nothing in these touches has none.

    Parameters
    ----------
    white : WhitenedTouches
        All trajectories.
    fit : JointFit
        The fit about which effects are changed; the strengths of its own effects stay as fitted.
    effects : sequence of str
        Names in the catalogue of effects.
    """
    answers = contacts(white.touch_set, fit.model.material, fit.model.offsets)
    rows = known_rows(white, np.concatenate([answer.wrench for answer in answers]))
    fields: dict[str, Array] = {}
    for signature in effect_signatures(white, fit.model.material, effects, fit.model.settings, fit.model.offsets):
        shapes = "".join(f", {name} {value:g}" for name, value in signature.shapes.items())
        sizes = signature.step_sizes * signature.scales
        for place, strength in enumerate(signature.strengths):
            parameter = strength.parameter
            size = f" at {sizes[place]:g} {parameter.unit}" if parameter.grid else ""
            change = white.with_own(signature.field[:, :, place]) * _single(white)
            fields[f"{EFFECTS[signature.effect]().title} ({strength.label}{size}{shapes})"] = change[rows]
    return fields


def case_noise(white: WhitenedTouches, fit: JointFit) -> NoiseModel:
    """Return the noise of the residuals of `case_residuals`: its correlation, and the scatter of the simulation."""
    inflation = float(np.mean([case.noise.inflation for case in white.touch_set.touches]))
    answers = contacts(white.touch_set, fit.model.material, fit.model.offsets)
    rows = known_rows(white, np.concatenate([answer.wrench for answer in answers]))
    scatter = np.sqrt(np.maximum(1.0 - white.weights[rows] ** 2, 0.0))
    return NoiseModel((inflation - 1.0) / (inflation + 1.0), scatter=scatter)


def locating(
    white: WhitenedTouches, fit: JointFit, seed: int = 0, draws: int = DRAWS, has_errors: bool = True
) -> LocateOptions:
    """Return the options with which locators test the residuals of a fit to touches.

    Parameters
    ----------
    white : WhitenedTouches
    fit : JointFit
        The fit whose residuals they are.
    seed, draws : int
        Seed and number of the sign flips.
    has_errors : bool
        Whether findings have to exceed errors of the simulation as well as noise.
    """
    noise = case_noise(white, fit)
    units = contrast_units(white, fit) if has_errors else dict.fromkeys(OF_THE_GEL, 0.0)
    errors = {name: OF_THE_GEL[name] * unit for name, unit in units.items()}
    return LocateOptions(noise=noise, seed=seed, draws=draws, is_fitted=True, errors=errors)


def locate_touches(
    white: WhitenedTouches, fit: JointFit, seed: int = 0, draws: int = DRAWS, has_errors: bool = True
) -> LocatorResults:
    """Return the results of all locators on the residuals of a fit to touches.

    Parameters
    ----------
    white : WhitenedTouches
    fit : JointFit
    seed, draws : int
        Seed and number of the sign flips.
    has_errors : bool
        Whether findings have to exceed errors of the simulation as well as noise. Where an effect is named they need
        not: the question is then where it shows, no longer whether it is there.

    Raises
    ------
    TactileDataError
        Too few trajectories.
    """
    return locate(case_residuals(white, fit), locating(white, fit, seed, draws, has_errors))


def _single(white: WhitenedTouches) -> Array:
    """Return factors (N, 1) that give whitened residuals a variance of 1 in single readings.

    Whitening divided by a larger noise, which allows for the correlation of neighbouring readings.
    """
    return np.sqrt(np.array([case.noise.inflation for case in white.touch_set.touches]))[white.trajectory, None]


def _parameters(white: WhitenedTouches, fit: JointFit) -> tuple[tuple[ResidualParameter, ...], list[Array]]:
    """Return the shared parameters and contact offset of a fit, and the whitened change (N, 6) over each."""
    # E, nu, mu and the contact offset
    gel, model = fit.model.material, fit.model
    low, high = (end[:3] for end in model.bounds)
    here = model.vector[:3]
    is_free = (here > low + 1e-6) & (here < high - 1e-6)
    modulus = gel.youngs_modulus * 1e-3
    by_log = fit.shared[:, :, 0]
    listed = [
        ResidualParameter("E", "kPa", modulus, is_tested=bool(is_free[0])),
        ResidualParameter("nu", "1", gel.poisson_ratio, is_tested=bool(is_free[1])),
        ResidualParameter("mu", "1", gel.friction, is_tested=bool(is_free[2])),
        ResidualParameter("contact offset", "mm", own_deviation=1e3 * PRIOR),
    ]
    fields = [by_log / modulus, fit.shared[:, :, 1], fit.shared[:, :, 2], fit.own / (1e3 * PRIOR)]
    # numbers of effects
    for place, coordinate in enumerate(model.coordinates):
        listed.append(ResidualParameter(model.name_of(coordinate), coordinate.parameter.unit, is_tested=False))
        fields.append(fit.shared[:, :, 3 + place])
    first = 3 + len(model.coordinates)
    for place, error in enumerate(white.simulation_errors):
        title = f"error of the simulation: {error.label}"
        listed.append(ResidualParameter(title, is_tested=False, prior_deviation=1.0))
        fields.append(fit.shared[:, :, first + place])
    return tuple(listed), fields


def _labels(white: WhitenedTouches, slides: NDArray[np.bool_]) -> dict[str, Names]:
    """Return labels (N,) by name; a label that divides the trajectories as an earlier one does is left out."""
    cases = white.touch_set.touches
    by_trajectory = {
        "indenter": white.touch_set.indenters,
        "sensor": tuple(case.touch.sensor for case in cases),
        "mount": tuple(case.touch.mount for case in cases),
    }
    labels: dict[str, Names] = {}
    seen: set[tuple[int, ...]] = set()
    for name, texts in by_trajectory.items():
        partition = tuple(texts.index(text) for text in texts)
        if len(set(partition)) > 1 and partition not in seen:
            seen.add(partition)
            labels[name] = np.array(texts)[white.trajectory]
    labels["phase"] = np.concatenate([phases(case) for case in cases])
    labels["contact"] = np.where(slides, "slip", "stick")
    return labels
