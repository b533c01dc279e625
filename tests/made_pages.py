"""Pages of every kind, each made by the toolkit's own code from a small input."""

from types import SimpleNamespace

import numpy as np
from closed_form import NOISE, ClosedFormWorld
from sealed_proofs import answered_proof
from tables import presses
from viewed_store import attach_planted

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.calibrate import Calibration
from tactiledata.calibrate.fit import fit
from tactiledata.calibrate.knowledge import known_parameters
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.page import calibration_page
from tactiledata.calibrate.remarks import remarks
from tactiledata.contract.simulated import SimulatedCount
from tactiledata.diagnose.answer.documents import errors
from tactiledata.diagnose.answer.formula_page import explanation_page
from tactiledata.diagnose.formula.explain import explain
from tactiledata.diagnose.locate.locate import LocateOptions
from tactiledata.diagnose.table_input.residuals_of import residuals_of
from tactiledata.ingest.sources.overview import write_report
from tactiledata.prove.page import write_page
from tactiledata.replay.overview import mesh_sections, write_replay_page
from tactiledata.store.read.reader import Store


def report_and_replay(store, out):
    """The report of a copied store with a planted mesh, and the page of that mesh."""
    attach_planted(store)
    opened = Store.open(store)
    return write_report(opened, out, further=mesh_sections(opened))["page"], write_replay_page(opened, "planted", out)


def calibration(out):
    """The page of a calibration on a world in closed form, where E hits its bound."""
    world = ClosedFormWorld(5)
    measured = world.measured(np.array([1.05e6, 0.478, 0.78]))
    experiment = world.experiment(measured)
    options, bounds = CalibrationOptions(), find_bounds("paper")
    found = fit(experiment, NOISE, bounds, options)
    played = found.parameters[0] * world.wrench(found.parameters[1], found.parameters[2], 0.0)
    findings = tuple(remarks(found, bounds, options.offset_prior, {"no pose": 1}, True))
    known = known_parameters(found.intervals, bounds, True)
    made = Calibration(
        options, bounds, SimpleNamespace(noise=NOISE), experiment, found, played, (0.001, 0.003), findings, "0" * 64,
        known, SimulatedCount(5, 0, 0, "trajectory"),
    )  # fmt: skip
    return written(out / "calibration.html", calibration_page(made))


def diagnosed_table(out):
    """The diagnosis of a table of presses in which the force rises with speed."""
    table = residuals_of(presses(1, 24, rate=0.15))
    told = explain(table.residuals, LocateOptions(draws=199))
    page = explanation_page(
        "Diagnosis of presses.csv", told, errors(table, told), ["One row had no force."], "24 groups"
    )
    return written(out / "table.html", page)


def proof(out):
    """The page of a proof with made-up answers, one of them missed."""
    folder = answered_proof(out / "proof")
    write_page(folder)
    return folder.page


def written(path, page):
    path.write_text(page, encoding="utf-8")
    return path
