"""How E, nu and mu of a diagnosis relate to those of other steps: a recorded world, a replay, the start of the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tactiledata.contract.wording import counted
from tactiledata.diagnose.answer.sentences import Answer, material_is_of
from tactiledata.diagnose.naming.intervals import ProfiledInterval
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.effects import EFFECTS
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.report.page import Section
from tactiledata.store.read.reader import Store


@dataclass(frozen=True)
class StatedMaterial:
    """E, nu and mu as another step states them.

    Parameters
    ----------
    step : str
        Name of the step.
    material : GelMaterial
        Its values.
    words : str
        Where they come from.
    residual : float, optional
        Residual that the step states, as a multiple of the noise.
    """

    step: str
    material: GelMaterial
    words: str
    residual: float | None = None


def materials_of_meshes(store: Store) -> tuple[StatedMaterial, ...]:
    """Return the materials with which the meshes of a store were made."""
    return tuple(
        StatedMaterial(
            f"mesh {name}",
            GelMaterial(**store.mesh(name).settings["material"]),
            "given to the replay with effects that were found"
            if store.mesh(name).settings.get("effects")
            else "given to the replay, from a calibration or by hand",
        )
        for name in store.mesh_names
    )


def material_of_calibration(document: Mapping[str, Any], name: str, elsewhere: str = "") -> StatedMaterial:
    """Return what a calibration states.

    Parameters
    ----------
    document : dict
        ``calibration.json`` (schemas/calibration.json).
    name : str
        Name of the file, for the table.
    elsewhere : str
        That it was made from another store, in words; empty where it was not.
    """
    fitted = counted(len(document["trajectories"]["fitted"]), "trajectory")
    material = GelMaterial(*(float(document[key]) for key in ("youngs_modulus", "poisson_ratio", "friction")))
    residual = document["losses"].get("vector", {}).get("fitted")
    words = f"{name}: fitted to {fitted} inside bounds ({document['bounds']['name']}), {document['fidelity']}"
    words = f"{words}; {elsewhere}" if elsewhere else words
    return StatedMaterial("calibration", material, words, residual)


def other_steps_section(naming: NamingResult, start: GelMaterial, stated: Sequence[StatedMaterial]) -> Section:
    """Return the section with E, nu and mu of all steps, and why they differ.

    Parameters
    ----------
    naming : NamingResult
        Gives the plain fit, and the fit with the claimed effects.
    start : GelMaterial
        Where the fits started.
    stated : sequence of StatedMaterial
        Materials of other steps.
    """
    decision, claimed = naming.decision, Answer(naming).names
    began = StatedMaterial("start of the fits", start, "from the Shore A hardness of the gel (Gent's formula)")
    rows = [_row(one.step, *_values(one.material), one.words) for one in (*stated, began)]
    plain = naming.base.model.material
    rows.append(_row("this diagnosis, plain", *_values(plain), "fitted with E free; makes up for missing physics"))
    text = (
        "E, nu and mu are fitted numbers. Each step fits them under other conditions, so that they may differ. A "
        "calibration looks for E inside bounds, mostly plays fewer trajectories, and takes what the simulation errs by "
        "for noise. Where a simulation lacks physics, these numbers make up for it, in each step in its own way: two "
        "intervals of E may then exclude each other. Once an effect is named, it explains what they had made up for."
    )
    sentences = [("info", text), *(("", words) for words in _beside(stated, naming.intervals_before[:1]))]
    if claimed and decision.best is not None:
        titles = " and ".join(EFFECTS[name]().title for name in claimed)
        fitted = decision.best.fit.model
        rows.append(_row(f"this diagnosis, with {titles}", *_values(fitted.material), "the value to take for the gel"))
        sentences += [("", words) for words in material_is_of(fitted.settings)]
    sentences += [("", words) for words in _residuals(stated)]
    return Section("E, nu and mu of other steps", sentences, ("step", "E, kPa", "nu", "mu", "where from"), rows)


def _values(material: GelMaterial) -> tuple[float, float, float]:
    """Return E (Pa), nu and mu of a material."""
    return material.youngs_modulus, material.poisson_ratio, material.friction


def _row(step: str, modulus: float, ratio: float, friction: float, words: str) -> tuple[str, ...]:
    """Return a row of the table."""
    return step, f"{modulus / 1e3:.0f}", f"{ratio:.3f}", f"{friction:.3f}", words


def _beside(stated: Sequence[StatedMaterial], plain: Sequence[ProfiledInterval]) -> list[str]:
    """Return a sentence on each stated E, held against the 95 % interval of the plain fit."""
    if not plain:
        return []
    low, high = plain[0].low, plain[0].high
    said = []
    for one in stated:
        modulus = one.material.youngs_modulus
        place = "inside" if low <= modulus <= high else "outside"
        said.append(
            f"E of {one.step}, {modulus / 1e3:.0f} kPa, lies {place} the 95 % interval of the plain fit, "
            f"{low / 1e3:.0f} to {high / 1e3:.0f} kPa."
        )
    return said


def _residuals(stated: Sequence[StatedMaterial]) -> list[str]:
    """Return a sentence on each stated residual, and why that of the diagnosis is another."""
    return [
        f"The {one.step} leaves {one.residual:.1f} times the noise. That is no measure of the fit here: a diagnosis "
        "also fits the place and tilt of touches, the sensor's zeros and errors of the simulation."
        for one in stated
        if one.residual is not None
    ]
