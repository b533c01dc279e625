"""The HTML page of a calibration: result, losses, findings, measured and simulated forces, loss around the optimum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactiledata.calibrate.bounds import NAMES, SYMBOLS
from tactiledata.calibrate.calibrate import Calibration
from tactiledata.calibrate.fit import norm_loss, vector_loss
from tactiledata.calibrate.losses import Loss
from tactiledata.calibrate.remarks import in_words
from tactiledata.calibrate.surface import loss_surface
from tactiledata.contract.wording import LINEAR_IS_LOW, counted
from tactiledata.report.calibration_plots import (
    ACROSS,
    LossSurface,
    Overlay,
    draw_overlays,
    draw_residuals,
    draw_surfaces,
)
from tactiledata.report.finding_words import codes_section
from tactiledata.report.page import Picture, Section, render_page
from tactiledata.report.panels import panels_of

MOST_OVERLAYS = 12
"""Most trajectories whose measured and simulated forces are drawn."""
KINDS = {"damage": "Damage", "warning": "Warning", "info": "Note"}
"""Word before a finding of each severity."""
LOSS_UNITS = {"vector": "times the noise", "norm": "N"}
"""Unit of each loss."""
LABELS = {"youngs_modulus": "E, kPa", "poisson_ratio": "nu", "friction": "mu"}


def calibration_page(calibration: Calibration, store: str = "") -> str:
    """Return the page of a calibration as HTML.

    It begins with a picture of measured and simulated forces, the result in three sentences, and what a reader should
    know of it. All else is folded below.

    Parameters
    ----------
    calibration : Calibration
        The result.
    store : str
        Name of the store, for the last line; empty where it has none.
    """
    more = _overlay_picture(calibration, ACROSS, MOST_OVERLAYS)
    folded = [
        _other_steps(calibration),
        *([] if more is None else [Section("More trajectories", pictures=[more])]),
        _losses(calibration),
        _surfaces(calibration),
        _residuals(calibration),
    ]
    sections = [_result(calibration), _remarks(calibration), *(replace(section, is_folded=True) for section in folded)]
    if (explained := codes_section(finding.code for finding in calibration.findings)) is not None:
        sections.append(explained)
    footer = f"{f'store {store}, ' if store else ''}store digest {calibration.store[:16]}"
    return render_page(
        "Calibration of the gel", _in_short(calibration), sections, footer,
        calibration.simulated, _overlay_picture(calibration, 0, ACROSS),
    )  # fmt: skip


def _in_short(calibration: Calibration) -> list[tuple[str, str]]:
    """Return the result as paragraphs: values, what they are, how well the forces agree, and what was fitted."""
    options, fit = calibration.options, calibration.fit
    values = [f"{symbol} is {value} ({interval})" for symbol, value, interval, *_ in result_rows(calibration)]
    norms = fit.losses["norm"]
    which, start, end = "fitted", norms.start, norms.fitted
    if np.isfinite(norms.held_out):
        which, start, end = "held-out", norms.held_out_start, norms.held_out
    preview = f" It is a preview: {LINEAR_IS_LOW}." if options.fidelity == "linear" else ""
    high = " It serves for comparison: its forces are too high." if options.engine == "mujoco-flex" else ""
    poses = ""
    if options.loss == "vector":
        poses = (
            ", poses as recorded; a replay moves each touch by the contact offset of this fit, and differs by another"
        )
    return [
        ("", f"{', '.join(values[:2])} and {values[2]}. In brackets are 95 % intervals."),
        ("info", "E is the stiffness of the gel (Young's modulus), nu its Poisson's ratio and mu its friction."),
        ("", f"On {which} trajectories simulated and measured forces differ by {end:.3f} N, and by {start:.3f} N before"
             f" the fit (mean difference of the norms{poses})."),
        ("", f"{counted(len(fit.fitted), 'trajectory')} fitted, {len(fit.held_out)} held out, "
             f"{counted(len(calibration.experiment.measured), 'frame')}; loss {options.loss}, engine {options.engine}, "
             f"fidelity {options.fidelity}.{preview}{high}"),
    ]  # fmt: skip


def _other_steps(calibration: Calibration) -> Section:
    """Section on how these values relate to those of other steps."""
    fit, bounds = calibration.fit, calibration.bounds
    start = in_words(NAMES[0], float(fit.start[0]))
    (_, low, high), *_ = bounds
    return Section(
        "Why other steps state another E",
        [
            ("", f"The fit begins at E {start}: Gent's formula for Shore A {calibration.options.shore_a:g}."),
            ("", f"A calibration looks for E from {in_words(NAMES[0], low)} to {in_words(NAMES[0], high)} only "
                 f"(bounds '{bounds.name}'). Where the simulation lacks physics, E, nu and mu make up for it as far as "
                 "they can. Then they are no properties of the gel."),
            ("", "A diagnosis (tactiledata diagnose) leaves E free, fits more trajectories and allows for errors of "
                 "the simulation. Its plain E may lie outside these bounds, or outside the interval above. Neither E "
                 "is right where physics is missing. With a named effect E changes again: the effect explains "
                 "what E had made up for. Take that value for the gel."),
            ("", "A replay takes the values that it is given, and its mesh states them."),
        ],
    )  # fmt: skip


def result_rows(calibration: Calibration) -> list[tuple[str, ...]]:
    """One row of texts per parameter: symbol, value, 95 % interval, interval with simulation error, start, verdict."""
    fit = calibration.fit
    bounds = [(low, high) for _, low, high in calibration.bounds]
    rows: list[tuple[str, ...]] = []
    for k, name in enumerate(NAMES):
        ends = [
            in_words(name, float(end)) + (" (bound)" if is_open else "")
            for end, is_open in zip(fit.intervals.ends[k], fit.intervals.is_open[k], strict=True)
        ]
        value, start = in_words(name, float(fit.parameters[k])), in_words(name, float(fit.start[k]))
        with_simulation_error = " to ".join(
            in_words(name, float(end)) + (" (bound)" if np.isclose(end, bounds[k], rtol=1e-6).any() else "")
            for end in fit.simulation_error.ends[k]
        )
        rows.append(
            (SYMBOLS[name], value, " to ".join(ends), with_simulation_error, start, calibration.known[name].verdict)
        )
    return rows


def loss_rows(calibration: Calibration) -> list[tuple[str, ...]]:
    """One row of texts per loss: name and unit, at the start, at the optimum, held out at both."""
    return [
        (
            f"{name}, {LOSS_UNITS[name]}",
            *(f"{value:.3f}" if np.isfinite(value) else "-" for value in vars(values).values()),
        )
        for name, values in calibration.fit.losses.items()
    ]


def _result(calibration: Calibration) -> Section:
    """Section with the parameters' table and the sentences on interpolation and simulation errors."""
    rms, largest = calibration.interpolation_error
    text = (
        "The fit interpolates between simulations. Interpolated forces differed from a simulation with the fitted "
        f"values by {rms:.3f} N (root mean square), and by {largest:.3f} N at most. They were corrected by that, and "
        "E, nu and mu were fitted again."
    )
    if calibration.fit.shape_factors:
        parts = [f"{name} {factor:.3f}" for name, factor in calibration.fit.shape_factors.items()]
        text += " Ratio of measured to simulated force, by indenter: " + ", ".join(parts) + "."
    errors = calibration.fit.simulation_error
    more = (
        "The interval with simulation error allows for what two simulators of one gel differ by: "
        f"{100 * errors.force:.0f} % in all forces alike, and {100 * errors.law:.0f} % more where forces grow by a "
        "factor of 2.7."
    )
    columns = ("", "value", "95 % interval", "with simulation error", "start", "verdict")
    return Section("Result", [("info", more), ("info", text)], columns, result_rows(calibration))


def _losses(calibration: Calibration) -> Section:
    """Section with the table of losses."""
    columns = ("loss", "start", "fitted", "held out, start", "held out")
    said = other_loss(calibration)
    return Section("Losses", [("info", said)] if said else (), columns, loss_rows(calibration))


def other_loss(calibration: Calibration) -> str:
    """Return why the loss that was not minimised is larger than at the start; empty where it is not."""
    chosen = calibration.options.loss
    worse = [name for name, values in calibration.fit.losses.items() if name != chosen and values.fitted > values.start]
    if not worse:
        return ""
    return (
        f"The fit lowers the {chosen} loss. The {worse[0]} loss is larger than at the start: the two weigh forces in "
        "different ways, and where the simulation lacks something no gel lowers both."
    )


def _remarks(calibration: Calibration) -> Section:
    """Section with the findings, or a sentence that there are none."""
    sentences = [
        (finding.severity, f"{KINDS[finding.severity]}: {finding.message} [{finding.code}]")
        for finding in calibration.findings
    ]
    return Section("What to know", sentences or [("", "Nothing stands out.")])


def _overlay_picture(calibration: Calibration, first: int, stop: int) -> Picture | None:
    """Picture of measured and simulated forces of some trajectories, by their places in an order; none without any.

    Held-out trajectories come first.
    """
    experiment, fit = calibration.experiment, calibration.fit
    held_out = set(fit.held_out.tolist())
    order = sorted(range(len(experiment.touches)), key=lambda place: (place not in held_out, place))[first:stop]
    if not order:
        return None
    overlays = []
    for place in order:
        touch, start = experiment.touches[place], experiment.response.starts[place]
        rows = slice(start, start + experiment.response.counts[place])
        overlays.append(
            Overlay(
                f"{touch.name} {touch.indenter}" + (" (held out)" if place in held_out else ""),
                touch.seconds[experiment.frames[place]],
                experiment.measured[rows, :3],
                calibration.simulated_wrenches[rows, :3],
            )
        )
    caption = (
        "Contact force over time, gel frame. Dots are measured, lines are simulated with the fitted E, nu and mu. "
        "Held-out trajectories had no part in the fit."
    )
    return panels_of(draw_overlays(overlays), caption)


def _surfaces(calibration: Calibration) -> Section:
    """Section with the loss over E and nu, and over E and mu, the third parameter at its optimum."""
    fit, bounds, options = calibration.fit, calibration.bounds, calibration.options
    loss: Loss
    if options.loss == "vector":
        loss = vector_loss(
            calibration.experiment, calibration.measured.noise, fit.fitted, options.offset_prior, options.shape_share
        )
    else:
        loss = norm_loss(calibration.experiment, fit.fitted)
    surfaces = []
    # E lies on the horizontal axis, in kPa; nu or mu on the vertical one
    for up in (1, 2):
        x, y, values = loss_surface(loss, bounds, fit.parameters, 0, up)
        best = (float(fit.parameters[0]) / 1e3, float(fit.parameters[up]))
        names = (LABELS[NAMES[0]], LABELS[NAMES[up]])
        title = f"{options.loss} loss, {SYMBOLS[NAMES[3 - up]]} at its optimum"
        unit = f"loss, {LOSS_UNITS[options.loss]}"
        surfaces.append(LossSurface(title, *names, unit, x / 1e3, y, values, best, float("nan")))
    caption = "The loss inside the bounds of the search. The smaller the loss, the better the forces agree."
    picture = panels_of(draw_surfaces(surfaces), caption)
    return Section("The loss around its optimum", pictures=[picture])


def _residuals(calibration: Calibration) -> Section:
    """Section with the residual forces of all frames."""
    measured = calibration.experiment.measured
    figure = draw_residuals(measured[:, 2], (measured - calibration.simulated_wrenches)[:, :3], ("Fx", "Fy", "Fz"))
    caption = (
        "Measured less simulated force of each frame, over the measured normal force (left), and in how many frames it"
        " occurs (right)."
    )
    return Section("What is left", pictures=[panels_of(figure, caption)])
