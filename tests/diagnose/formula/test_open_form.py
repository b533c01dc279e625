"""Open forms: the planted formula comes back, dimensionless, and noise gives none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planted import MODULUS, modulus_over, planted

from tactiledata.diagnose.formula.candidates import Candidates, carriers
from tactiledata.diagnose.formula.likeness import likenesses
from tactiledata.diagnose.formula.open_form import find_candidates, open_form
from tactiledata.diagnose.formula.select import false_terms_bound, halves, pursue, stable_choices
from tactiledata.diagnose.formula.terms import atoms
from tactiledata.diagnose.formula.unseen import held_out
from tactiledata.diagnose.residuals.dimensions import NONE, UNITS, find_unit
from tactiledata.diagnose.residuals.gap import gap_closed, scatter
from tactiledata.diagnose.residuals.history import fading_memory, largest_so_far
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Covariate


@pytest.mark.parametrize(
    ("text", "factor", "exponents"),
    [
        ("mm", 1e-3, (1, 0, 0, 0, 0)),
        ("N/mm", 1e3, (0, 1, -2, 0, 0)),
        ("N m", 1.0, (2, 1, -2, 0, 0)),
        ("mm^2", 1e-6, (2, 0, 0, 0, 0)),
        ("1/s", 1.0, (0, 0, -1, 0, 0)),
        ("nN", 1e-9, (1, 1, -2, 0, 0)),
        ("mbar", 100.0, (-1, 1, -2, 0, 0)),
        ("pF", 1e-12, (-2, -1, 4, 0, 2)),
        ("pct", 0.01, NONE),
        ("px/s", 1.0, (0, 0, -1, 0, 0, 1, 0)),
        ("counts", 1.0, (0, 0, 0, 0, 0, 0, 1)),
        ("kPa s", 1e3, (-1, 1, -1, 0, 0)),
        ("deg", np.pi / 180, NONE),
    ],
)
def test_units_are_read(text, factor, exponents):
    """A unit is read as its factor to SI and its exponents."""
    unit = find_unit(text)
    assert unit.factor == pytest.approx(factor)
    assert unit.exponents == tuple(map(float, exponents)) + (0.0, 0.0) * (len(exponents) == 5)


@pytest.mark.parametrize("text", ["", "furlong", "mm/", "N//m", "1e3"])
def test_what_is_no_unit_is_none(text):
    """What is no unit gives None rather than a number."""
    assert find_unit(text) is None


@given(st.sampled_from(sorted(UNITS)), st.integers(-3, 3))
def test_powers_multiply(name, power):
    """A unit times its power is the next power."""
    unit = UNITS[name]
    one, other = unit.power(power).times(unit), unit.power(power + 1)
    assert one.exponents == pytest.approx(other.exponents)
    assert one.factor == pytest.approx(other.factor)


def test_only_dimensionless_numbers_are_made():
    """Changing the unit of every covariate changes no ratio and no group."""
    world = planted(0)
    rng = np.random.default_rng(0)
    given = {
        "depth": Covariate(rng.uniform(0.1, 1, 600), "mm"),
        "thickness": Covariate(rng.uniform(2, 5, 600), "mm"),
        "force": Covariate(rng.uniform(1, 10, 600), "N"),
        "modulus": Covariate(rng.uniform(0.5, 2, 600), "MPa"),
    }
    in_si = {
        name: Covariate(one.values * find_unit(one.unit).factor, unit)
        for (name, one), unit in zip(given.items(), ("m", "m", "N", "Pa"), strict=True)
    }
    both = [
        {
            atom.name: atom.values
            for atom in atoms(type(world)(world.values, world.components, world.groups, covariates))
            if "/(" not in atom.name or atom.name.startswith("(")
        }
        for covariates in (given, in_si)
    ]
    assert "depth/thickness" in both[0]
    assert "(depth^2 force^-1 modulus)" in both[0] or "(force depth^-2 modulus^-1)" in both[0]
    assert not [name for name in both[0] if name == "depth/force"]
    for name, values in both[0].items():
        np.testing.assert_allclose(values, both[1][name], rtol=1e-9, err_msg=name)


def test_memories_are_those_of_a_loop():
    """Running maximum and fading memory are those of a loop that is written out, trajectory by trajectory."""
    rng = np.random.default_rng(0)
    starts = np.array([0, 5, 12])
    values, seconds = rng.normal(size=20), np.cumsum(rng.uniform(0.1, 1, 20))
    largest, memory = largest_so_far(values, starts), fading_memory(values, seconds, starts, 0.7)
    for first, last in zip(starts, [5, 12, 20], strict=True):
        for row in range(first, last):
            assert largest[row] == values[first : row + 1].max()
            kept = values[first] * np.exp(-(seconds[row] - seconds[first]) / 0.7)
            for earlier in range(first + 1, row + 1):
                kept += (values[earlier] - values[earlier - 1]) * np.exp(-(seconds[row] - seconds[earlier]) / 0.7)
            assert memory[row] == pytest.approx(kept)


def test_pursuit_agrees_with_a_plain_twin():
    """Picks of the batched sweep are those of least squares solved anew for each."""
    rng = np.random.default_rng(1)
    design = rng.normal(size=(60, 12))
    target = design[:, 3] * 2 - design[:, 7] + 0.5 * design[:, 9] + rng.normal(0, 0.1, 60)
    picks = pursue((design.T @ target)[None], (design.T @ design)[None])[0]
    chosen: list[int] = []
    for _ in range(3):
        left = target - (design[:, chosen] @ np.linalg.lstsq(design[:, chosen], target, rcond=None)[0] if chosen else 0)
        gains = []
        for term in range(12):
            column = design[:, term]
            if chosen:
                column = column - design[:, chosen] @ np.linalg.lstsq(design[:, chosen], column, rcond=None)[0]
            size = column @ column
            gains.append((column @ left) ** 2 / size if size > 1e-9 else 0.0)
        chosen.append(int(np.argmax(gains)))
    assert picks.tolist() == chosen


def test_terms_that_are_used_up_get_no_votes():
    """Two terms explain all: no half chooses a third one, where no residual is left.

    Beside the first of two terms, the second and their sum, numbered 0, explain the rest alike: either may be chosen.
    """
    first, second = np.linalg.qr(np.random.default_rng(3).normal(size=(5, 2)))[0].T
    design = np.stack([first + second, first, second], axis=1)
    # eight units of exchange, all alike
    scores = np.tile(design.T @ (5.0 * first - 3.0 * second), (8, 1))
    grams = np.tile(design.T @ design, (8, 1, 1))
    (picks,) = pursue(scores[:1], grams[:1]).tolist()
    assert picks in ([1, 2, -1], [1, 0, -1])
    choices = stable_choices(scores, grams, np.random.default_rng(0))
    votes = {int(place): choice.inclusion for choice in choices for place in choice.members}
    assert votes == {1: 1.0, picks[1]: 1.0}
    assert pursue(np.zeros((1, 3)), grams[:1]).tolist() == [[-1, -1, -1]]
    # without rounding the first of equal terms is chosen, here before their sum, numbered 3
    first, second, third = np.eye(5)[:3]
    design = np.stack([third, first, second, first + second], axis=1)
    scores = np.tile(design.T @ (5.0 * first - 3.0 * second), (8, 1))
    grams = np.tile(design.T @ design, (8, 1, 1))
    assert pursue(scores[:1], grams[:1]).tolist() == [[1, 2, -1]]
    choices = stable_choices(scores, grams, np.random.default_rng(0))
    assert {int(place): choice.inclusion for choice in choices for place in choice.members} == {1: 1.0, 2: 1.0}


def test_halves_are_complementary():
    """Each pair of halves divides the units in two."""
    masks = halves(11, np.random.default_rng(0), 20)
    assert (masks.sum(axis=1) == 5).all()
    assert (masks[0::2] + masks[1::2]).max() == 1.0


def test_the_bound_falls_with_the_number_of_different_terms():
    """Copies of a term do not count."""
    rng = np.random.default_rng(0)
    few, many = rng.normal(size=(40, 5)), rng.normal(size=(40, 30))
    assert false_terms_bound(few) > false_terms_bound(many)
    assert false_terms_bound(np.repeat(few, 6, axis=1)) == pytest.approx(false_terms_bound(few), rel=0.05)


@pytest.mark.parametrize(
    ("covariate", "low", "high", "logarithmic", "expected", "coefficient"),
    [
        ("depth", 0.2, 1.0, False, "depth/(1.0 mm)", 0.3 / 0.8),
        ("speed", 0.1, 10.0, True, "log10(speed/(1.0 mm/s))", 0.15),
        ("minutes", 0.0, 90.0, False, "minutes/(80 min)", 0.3 * 80 / 90),
    ],
)
def test_the_planted_formula_comes_back(covariate, low, high, logarithmic, expected, coefficient):
    """The formula has one term, the right carrier, and the right coefficient within its interval or 15 %."""
    world = planted(1, 60, plant=modulus_over(covariate, 0.3, low, high, logarithmic))
    found = open_form(world)
    assert [(term.carrier, term.term) for term in found.terms] == [("E", expected)]
    term = found.terms[0]
    assert abs(term.coefficient - coefficient) < max(term.half_width, 0.15 * coefficient)
    assert term.inclusion >= 0.8
    assert term.words.startswith("E (1 + (")


def test_two_terms_at_once():
    """E with depth, and a shear force that comes with the clock."""

    def plant(world):
        values = modulus_over("depth", 0.4, 0.2, 1.0)(world)
        values[:, 1] += 0.03 * world.covariates["minutes"].values
        return values

    found = open_form(planted(2, 80, plant=plant))
    assert {term.carrier for term in found.terms} == {"E", "fy"}
    assert any("minutes" in term.term for term in found.terms)


@pytest.mark.slow
def test_noise_gives_no_formula():
    """A formula is found in at most 3 of 60 nulls."""
    assert sum(bool(open_form(planted(seed, 24, 10), seed=seed).terms) for seed in range(60)) <= 3


def test_a_known_signature_is_recognised():
    """The sum behaves like its own truth, and not like a signature of another kind."""
    world = planted(1, 60, plant=modulus_over("speed", 0.3, 0.1, 10.0, True))
    other = np.zeros_like(world.values)
    other[:, 0] = world.covariates["x"].values
    found = open_form(world, {"rate": modulus_over("speed", 1, 0.1, 10.0, True)(world), "other": other})
    assert found.behaves_like[0].name == "rate"
    assert found.behaves_like[0].is_near
    assert not found.behaves_like[1].is_near
    assert "behaves like rate" in found.words


def test_likeness_ignores_what_a_refit_takes():
    """A signature plus any multiple of E's own sensitivity is the same signature."""
    world = planted(3)
    field = modulus_over("depth", 1, 0.2, 1.0)(world)
    same = field + 500.0 * world.slopes[:, :, 0]
    assert likenesses(project(world), field, {"same": same})[0].cosine == pytest.approx(1.0, abs=1e-6)


def test_what_a_refit_takes_whole_resembles_nothing():
    """A signature that E imitates leaves rounding errors alone, and its cosine is 0."""
    world = planted(0)
    field = np.random.default_rng(1).normal(size=world.values.shape)
    found = likenesses(project(world), field, {"imitated": 3.0 * world.slopes[:, :, 0], "same": field})
    assert [(one.name, one.cosine) for one in found] == [("same", pytest.approx(1.0)), ("imitated", 0.0)]


@pytest.mark.slow
def test_held_out_trajectories_fit_better_with_a_true_term_and_no_worse_without():
    """Most of the gap closes where a term was planted; nothing moves where none was."""
    world = planted(4, 60, plant=modulus_over("depth", 0.6, 0.2, 1.0), random_effects=False)
    found = held_out(world, find_candidates(world))
    gap = gap_closed(found.squares_before, found.squares_after, found.counts, scatter(found.after, world.starts))
    assert gap.closed > 0.4
    assert gap.interval[0] > 0.2
    quiet = planted(4, 60)
    left = held_out(quiet, find_candidates(quiet))
    assert left.squares_after.sum() <= 1.01 * left.squares_before.sum()


def test_the_gap_is_what_it_says():
    """Half of the way from 3 to 1 is 2; an interval holds it; no gap is NaN."""
    counts = np.full(30, 10.0)
    rng = np.random.default_rng(0)
    before, after = 9.0 * counts * rng.uniform(0.9, 1.1, 30), 4.0 * counts * rng.uniform(0.9, 1.1, 30)
    gap = gap_closed(before, after, counts, 1.0)
    assert gap.closed == pytest.approx(0.5, abs=0.03)
    assert gap.interval[0] < gap.closed < gap.interval[1]
    assert np.isnan(gap_closed(before, after, counts, 5.0).closed)


def test_scatter_does_not_see_smooth_structure():
    """The scatter of noise of 0.3 on a parabola is that of the noise."""
    rng = np.random.default_rng(0)
    values = rng.normal(0, 0.3, (5000, 2)) + (np.linspace(-5, 5, 5000) ** 2)[:, None]
    assert scatter(values, np.array([0, 2500])) == pytest.approx(0.3, rel=0.03)
    assert np.isnan(scatter(values[:2], np.array([0])))


def test_parameters_without_a_value_carry_nothing():
    """A share of something unknown is no coefficient; components are always carriers."""
    world = planted(0)
    assert [one.name for one in carriers(world)] == ["E", "mu", "fx", "fy", "fz"]
    candidates = Candidates.of(carriers(world), atoms(world))
    number = len(candidates.names) * 4
    assert candidates.carrier_of(number).unit == "N"
    np.testing.assert_allclose(candidates.sizes[number], (candidates.field(number) ** 2).sum())


def test_same_seed_same_formula():
    """Bit for bit, and the coefficient is E's share: in kPa it is MODULUS times it."""
    world = planted(1, 40, plant=modulus_over("depth", 0.3, 0.2, 1.0))
    one, other = open_form(world, seed=3), open_form(world, seed=3)
    assert one.terms == other.terms
    np.testing.assert_array_equal(one.fitted, other.fitted)
    expected = world.slopes[:, :, 0] * (MODULUS * one.terms[0].coefficient * world.covariates["depth"].values)[:, None]
    assert [term.term for term in one.terms] == ["depth/(1.0 mm)"]
    np.testing.assert_allclose(one.fitted, expected)
