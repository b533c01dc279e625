"""The first sentence of a table's diagnosis: it says no more than the rest of the page bears out."""

import re
from dataclasses import replace

import numpy as np
import pytest
from tables import presses

from tactiledata.contract.schema import check_document
from tactiledata.diagnose.answer.documents import table_document
from tactiledata.diagnose.answer.formula_page import explanation_page
from tactiledata.diagnose.formula.candidates import Candidates, carriers
from tactiledata.diagnose.formula.explain import Explanation, explain
from tactiledata.diagnose.formula.terms import atoms
from tactiledata.diagnose.formula.unseen import UnseenFormula
from tactiledata.diagnose.locate.locate import LocateOptions
from tactiledata.diagnose.residuals.ceiling import BlackBox, black_box
from tactiledata.diagnose.residuals.gap import Gap, is_improved
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import ResidualParameter
from tactiledata.diagnose.residuals.slopes import Change
from tactiledata.diagnose.table_input.residuals_of import residuals_of


def rippled(seed=0, size=1.0):
    """A joint whose torque ripples twelve times over its range: no slope, no step, no level."""
    rng = np.random.default_rng(seed)
    table = presses(seed, 40, 40, noise=False, correlation=0.0)[["trial", "fz_predicted_N", "fz_observed_N"]]
    angle = rng.uniform(-1, 1, len(table))
    ripple = 0.1 * size * np.sin(12 * np.pi * angle)
    return table.assign(angle_rad=angle, fz_observed_N=table.fz_observed_N + ripple)


@pytest.mark.slow
def test_what_only_a_black_box_foresees_is_structured_and_not_named():
    """Ripple that no locator sees; the page, the document and the exit code agree. Without it nothing is found."""
    table = residuals_of(rippled())
    told = explain(table.residuals, LocateOptions(draws=499))
    assert not told.located.is_structured
    assert told.ceiling.explained > 0.15
    assert (told.answer, told.is_found) == ("structured, not named", True)
    assert told.sentences()[0].startswith("Structured, not named")
    assert not any("Nothing found" in sentence for sentence in told.sentences())
    document = table_document(table, told, "0" * 64, 0)
    check_document(document, "diagnosis", "test")
    assert document["answer"] == "structured, not named"
    quiet = explain(residuals_of(rippled(size=0.0)).residuals, LocateOptions(draws=499))
    assert (quiet.answer, quiet.is_found) == ("nothing found", False)


@pytest.mark.slow
def test_a_common_offset_alone_is_headed_as_a_calibration():
    """0.5 N on every observation: a zero, and nothing is missing."""
    table = presses(3, 40)
    table["fz_observed_N"] += 0.5
    told = explain(residuals_of(table).residuals, LocateOptions(draws=499))
    assert told.answer == "calibration"
    assert told.sentences()[0].startswith("A calibration is off, and nothing else is found")
    assert not any("missing" in sentence for sentence in told.sentences())
    rate = explain(residuals_of(presses(1, 40, rate=0.15)).residuals, LocateOptions(draws=499))
    assert rate.answer == "explained"


@pytest.fixture(scope="module")
def explained() -> Explanation:
    return explain(residuals_of(presses(1, 40, rate=0.15)).residuals, LocateOptions(draws=499))


def held(before, after):
    rows = np.zeros((1, 1))
    return UnseenFormula(rows, rows, before, after, np.full(len(before), 10.0))


@pytest.mark.parametrize(("closed", "gained"), [(0.0, 0.0), (0.004, 0.5), (-0.2, -1.0)])
def test_the_first_sentence_follows_the_held_out_groups(explained, closed, gained):
    """A formula that closes nothing there explains no part; the one that was planted does."""
    assert explained.sentences()[0].startswith("Something is missing, and a formula explains it")
    before = np.linspace(9, 11, 40)
    failed = replace(
        explained, held=held(before, before - gained), gap=Gap(1.0, 1.0, 0.5, closed, (closed - 0.1, closed + 0.1))
    )
    assert failed.answer == "not explained"
    first, *others = failed.sentences()
    assert first.startswith("Something is missing, and no short formula explains it.")
    assert "does not hold on groups that had no part in it" in first
    assert not any(words in sentence for sentence in others for words in ("After the formula", "All refitted"))


def test_an_improvement_is_sure_or_is_none():
    """40 gains of mean 0.5 and scatter 1 are sure (t of 3.2); of mean 0.1 they are not; none is none."""
    rng = np.random.default_rng(0)
    scatter = rng.normal(size=40)
    scatter = (scatter - scatter.mean()) / scatter.std(ddof=1)
    before = np.full(40, 10.0)
    assert is_improved(before, before - 0.5 - scatter)
    assert not is_improved(before, before - 0.1 - scatter)
    assert not is_improved(before, before)
    assert not is_improved(before, before + 0.5 + scatter)


NOISES = {
    "normal": lambda rng, n: rng.normal(size=n),
    "heavy tails": lambda rng, n: rng.standard_t(3, n),
    "skewed": lambda rng, n: rng.exponential(size=n) - 1.0,
    "own offsets": lambda rng, n: rng.normal(size=n) + np.repeat(rng.normal(size=n // 12), 12),
    "own sizes": lambda rng, n: rng.normal(size=n) * np.repeat(np.exp(rng.normal(size=n // 12)), 12),
}


@pytest.mark.slow
@pytest.mark.parametrize("law", NOISES)
def test_a_black_box_foresees_nothing_of_noise(law):
    """A black box foresees something in at most 2 of 20 empty tables, whatever the law; 1 % is meant."""
    alarms = 0
    for seed in range(20):
        table = presses(seed, 24, 12, noise=False)
        table["fz_observed_N"] = table.fz_predicted_N + 0.1 * NOISES[law](np.random.default_rng(seed), len(table))
        alarms += black_box(project(residuals_of(table).residuals), seed).is_certain
    assert alarms <= 2


def test_certain_is_both_enough_and_no_chance():
    """A large share by chance is none, nor is a sure share of a thousandth."""
    made = BlackBox(np.zeros((1, 1)), np.zeros(1), 0.2, 0.001)
    assert made.is_certain
    assert not replace(made, p=0.05).is_certain
    assert not replace(made, explained=0.001).is_certain


def nearly_constant(noise=0.1, size=1e-3):
    """Predictions of a few mN beside observations of half a newton: a model that says next to nothing."""
    rng = np.random.default_rng(0)
    table = presses(1, 40, noise=False)
    small = size * (rng.normal(size=len(table)) + 2 * table.depth_mm)
    return table.assign(
        fz_predicted_N=small, fz_observed_N=0.5 * table.depth_mm + noise * rng.normal(size=len(table))
    )  # fmt: skip


@pytest.mark.slow
def test_scale_and_offset_that_cannot_be_told_apart_are_said_to_be_so():
    """No share of 7200 % is printed; where the prediction varies enough, or is followed, its scale is asked."""
    table = residuals_of(nearly_constant())
    assert [one.name for one in table.residuals.parameters] == ["the offset of fz"]
    assert "scale and offset of fz cannot be separated with these data" in " ".join(table.notes)
    sentences = " ".join(explain(table.residuals, LocateOptions(draws=299)).sentences())
    assert "offset of fz" in sentences
    assert "scale of fz" not in sentences
    assert len(residuals_of(presses()).residuals.parameters) == 2
    thousandfold = presses().assign(fz_predicted_N=lambda t: 1e-3 * t.fz_predicted_N)
    assert len(residuals_of(thousandfold).residuals.parameters) == 2


def test_a_share_that_is_not_known_to_its_own_size_is_no_number():
    """17000 ± 4000 % is none, 11 ± 2 % is one."""
    scale = ResidualParameter("the scale of fz", "1", 1.0)
    for words in (Change(scale, 170.0, 40.0).words, Change(scale, 170.0, 40.0).offset_words):
        assert "%" not in words
        assert "these data" in words
    assert Change(scale, 0.11, 0.02).words == "the scale of fz rises by 11 ± 2 %"
    # a modulus or a friction cannot fall by more than all of it
    assert Change(scale, -0.8, 0.3).words == "the scale of fz falls by 80 ± 30 %"
    assert Change(scale, -1.4, 0.4).words == "the scale of fz falls by more than all of its value"
    assert Change(scale, 1.4, 0.4).words == "the scale of fz rises by 140 ± 40 %"


@pytest.mark.slow
def test_the_printed_formula_can_be_computed_from_what_is_printed():
    """A memory of 1 s: the sentences alone, read as a stranger would, give the tool's own prediction."""
    table = presses(2, 40, 20, noise=False)
    rng = np.random.default_rng(5)
    table["time_s"] = table.groupby("trial").time_s.transform(lambda t: np.cumsum(rng.uniform(0.1, 0.5, len(t))))
    plain = []
    for _, rows in table.groupby("trial"):
        depth, seconds, memory = rows.depth_mm.to_numpy(), rows.time_s.to_numpy(), [rows.depth_mm.iloc[0]]
        for row in range(1, len(rows)):
            kept = np.exp(-(seconds[row] - seconds[row - 1]) / 1.0)
            memory.append(memory[-1] * kept + depth[row] - depth[row - 1])
        plain += memory
    table["fz_observed_N"] += 2.0 * np.array(plain)
    read = residuals_of(table)
    told = explain(read.residuals, LocateOptions(draws=299), "time")
    sentences = told.sentences()
    (formula,) = (one for one in sentences if one.startswith("All refitted together: corrected fz = "))
    (meant,) = (one for one in sentences if one.startswith("Here depth remembered for 1 s/("))
    over = float(re.search(r"is m/([\d.]+):", meant).group(1))
    for words in (
        "first row of a group m is depth in mm",
        "exp(-(seconds since that row)/1)",
        "plus the change of depth",
    ):
        assert words in meant
    said = re.sub(r"depth remembered for 1 s/\([^)]*\)", "memory", formula.split(" = ")[1].removesuffix("."))
    said = re.sub(r"(\d) N\b", r"\1", said.replace("predicted fz", "fz")).replace("×", "*")
    values = {"memory": np.array(plain) / over, "fz": table.fz_predicted_N.to_numpy()}
    computed = eval(said, {"__builtins__": {}}, values)
    left = project(read.residuals.with_fields(told.form.fields)).left[:, 0] * read.residuals.deviations[0]
    np.testing.assert_allclose(computed, table.fz_observed_N - left, atol=0.03)
    document = table_document(read, told, "0" * 64, 0)
    check_document(document, "diagnosis", "test")
    assert [f"Here {one}." for one in document["open_form"]["definitions"]] == [meant]
    assert meant.replace(">", "&gt;") in explanation_page("t", told, [], [], "")


def test_every_atom_says_how_it_is_computed():
    """Its definition begins with its own name; those of products are those of their parts, each once."""
    listed = atoms(residuals_of(presses().assign(width_mm=lambda t: 1 + t.trial / 10)).residuals, time="time")
    assert all(one.definition.startswith(f"{one.name} is ") for one in listed)
    read = residuals_of(presses()).residuals
    candidates = Candidates.of(carriers(read), atoms(read))
    (square,) = (n for n, name in enumerate(candidates.names) if name == "log10(speed/(1.0 mm/s))^2")
    meant = candidates.definitions_of([square, candidates.names.index("log10(speed/(1.0 mm/s))")])
    assert meant == ("log10(speed/(1.0 mm/s)) is the logarithm to base 10 of speed in mm/s over 1",)
