"""Tables: what columns mean, what is said of bad ones, and what a diagnosis of good ones finds."""

import decimal
import gzip
import json
import re

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tables import presses

from tactiledata.contract.schema import check_document
from tactiledata.diagnose.answer.formula_page import DEPENDENCE_CAPTION
from tactiledata.diagnose.formula.terms import atoms
from tactiledata.diagnose.table import diagnose_table, write_diagnosis
from tactiledata.diagnose.table_input.columns import columns_of, split_unit
from tactiledata.diagnose.table_input.read import doubts_of, read_table
from tactiledata.diagnose.table_input.residuals_of import residuals_of
from tactiledata.errors import MissingFile, TactileDataError, UnknownName, UsageError


def saved(folder, table, name="table.csv"):
    path = folder / name
    if name.endswith("parquet"):
        table.to_parquet(path)
    else:
        table.to_csv(path, index=False, sep="\t" if name.endswith("tsv") else ",")
    return path


@pytest.mark.parametrize(
    ("column", "name", "unit"),
    [
        ("depth_mm", "depth", "mm"),
        ("speed_mm_per_s", "speed", "mm/s"),
        ("speed_mm_s", "speed", "mm/s"),
        ("torque_N_m", "torque", "N m"),
        ("stiffness_N_per_mm", "stiffness", "N/mm"),
        ("strain_rate_per_s", "strain_rate", "1/s"),
        ("c1_per_mm", "c1", "1/mm"),
        ("jerk_per_s2", "jerk", "1/s2"),
        ("speed_rad_per_s", "speed", "rad/s"),
        ("speed_m_per_s", "speed", "m/s"),
        ("pressure_N_per_mm2", "pressure", "N/mm2"),
        ("spring_N_m_per_rad", "spring", "N m/rad"),
        ("damping_N_s_per_m", "damping", "N s/m"),
        ("heat_J_per_kg_K", "heat", "J/kg/K"),
        ("ramp_N_per_mm_per_s", "ramp", "N/mm/s"),
        ("stiffness_N_m-1", "stiffness", "N m-1"),
        ("gel_deg_C", "gel", "degC"),
        ("signal_counts", "signal", "counts"),
        ("depth_mm_1", "depth_mm_1", "?"),
        ("force_per", "force_per", "?"),
        ("index", "index", "?"),
        ("sensor_1", "sensor_1", "?"),
        ("step_time", "step_time", "?"),
        ("fz_observed_N", "fz_observed", "N"),
    ],
)
def test_units_are_read_off_names(column, name, unit):
    """An ending that is a unit is one; any other belongs to the name."""
    assert split_unit(column) == (name, unit)


@pytest.mark.parametrize("unit", ["nN", "uN", "px", "bar", "counts", "pct", "degC", "V", "mV_per_N", "furlong", "a_u"])
def test_observed_and_predicted_may_be_in_any_unit(unit):
    """A unit that is not known is a word of its own, read where both end in it."""
    table = presses().rename(columns=lambda name: name.replace("_N", f"_{unit}") if name.startswith("fz") else name)
    (quantity,) = columns_of(table).quantities
    said = {"mV_per_N": "mV/N", "a_u": "a u"}.get(unit, unit)
    assert (quantity.name, quantity.unit, quantity.noise) == ("fz", said, f"fz_noise_{unit}")
    assert residuals_of(table).residuals.units == (said,)


def test_an_ending_that_only_one_has_is_no_unit():
    """A covariate whose name goes on after "observed" stays one; two pairs of one name are refused."""
    table = presses().assign(fz_observed_left=lambda t: t.depth_mm)
    assert columns_of(table).covariates["fz_observed_left"] == ("fz_observed_left", "?")
    twice = table.assign(fz_predicted_left=1.0)
    with pytest.raises(UsageError, match="mean the same"):
        columns_of(twice)


def test_a_rate_makes_no_number_with_a_time():
    """Neither time over rate nor a rate over seconds; what shares its dimension is its ratio."""
    rng = np.random.default_rng(0)
    table = presses().assign(strain_rate_per_s=lambda t: rng.uniform(0.01, 0.05, len(t)),
                             f0_Hz=lambda t: rng.uniform(1, 2, len(t)))  # fmt: skip
    names = [atom.name for atom in atoms(residuals_of(table).residuals, time="time")]
    assert not [name for name in names if "time/strain_rate" in name or "strain_rate/time" in name]
    assert "strain_rate/(0.050 1/s)" in names or "strain_rate/(0.040 1/s)" in names or "strain_rate/(0.050/s)" in names
    assert "strain_rate/f0" in names


def test_names_say_what_columns_are():
    """Names tell the group, the quantity with its noise, covariates with units, labels and time."""
    columns = columns_of(presses())
    assert columns.group == "trial"
    quantity = columns.quantities[0]
    assert (quantity.name, quantity.unit, quantity.noise) == ("fz", "N", "fz_noise_N")
    assert columns.covariates["speed"] == ("speed_mm_per_s", "mm/s")
    assert (columns.labels, columns.time) == (("indenter",), "time")


def test_a_document_says_the_same():
    """A table that is described by a document has the same residuals as by its names."""
    table = presses()
    document = {
        "format": "tactiledata-columns/1",
        "group": "trial",
        "quantities": {"fz": {"observed": "fz_observed_N", "predicted": "fz_predicted_N", "noise": 0.1, "unit": "N"}},
        "covariates": {
            "time": {"column": "time_s", "unit": "s"},
            "depth": {"column": "depth_mm", "unit": "mm"},
            "speed": {"column": "speed_mm_per_s", "unit": "mm/s", "scale": 2.0},
        },
        "labels": ["indenter"],
        "time": "time",
    }
    check_document(document, "columns", "test")
    one, other = residuals_of(table), residuals_of(table, document)
    np.testing.assert_allclose(one.residuals.values, other.residuals.values)
    assert one.residuals.covariates.keys() == other.residuals.covariates.keys()
    assert other.columns.scales == {"speed": 2.0}
    with pytest.raises(UnknownName, match="depth"):
        columns_of(table, {**document, "order": "dept"})


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15)
def test_the_order_of_rows_does_not_matter(seed):
    """Rows come back in order of groups and time, whatever order the file has, up to the order of the groups."""
    table = presses(1, 10, 6)
    shuffled = table.sample(frac=1.0, random_state=seed)
    one, other = residuals_of(table).residuals, residuals_of(shuffled).residuals
    first = one.values[np.lexsort((one.covariates["time"].values, one.covariates["speed"].values))]
    second = other.values[np.lexsort((other.covariates["time"].values, other.covariates["speed"].values))]
    np.testing.assert_allclose(first, second)
    assert len(other.starts) == 10


def test_the_residual_is_over_the_noise_or_over_its_scatter():
    """0.1 N of noise makes a variance of about 1; without it the scatter does so exactly."""
    known = residuals_of(presses(0))
    assert known.is_noise_known
    np.testing.assert_allclose(
        known.residuals.values[:, 0], 10 * (presses(0).fz_observed_N - presses(0).fz_predicted_N)
    )
    unknown = residuals_of(presses(0, noise=False))
    assert not unknown.is_noise_known
    assert np.std(unknown.residuals.values) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("name", ["table.csv", "table.tsv", "table.parquet"])
def test_tables_are_read(name, tmp_path):
    """Numbers come back as they were."""
    table = presses(0, 9)
    pd.testing.assert_frame_equal(read_table(saved(tmp_path, table, name)), table)


BAD = {
    "a group that is not there": (lambda t: t.drop(columns="trial"), UsageError, "--group"),
    "a prediction that is not there": (
        lambda t: t.rename(columns={"fz_predicted_N": "fz_predictd_N"}), UnknownName, "fz_predictd_N",
    ),
    "no pair at all": (
        lambda t: t.drop(columns=["fz_observed_N", "fz_predicted_N", "fz_noise_N"]), UsageError, "observed and predict",
    ),
    "one group": (lambda t: t.assign(trial="a"), TactileDataError, "one group only"),
    "too few groups": (lambda t: t[t.trial < 5], TactileDataError, "5 groups only"),
    "a constant observation": (lambda t: t.assign(fz_observed_N=1.5), TactileDataError, "1.5 in every row"),
    "an observation whose squares are 0": (
        lambda t: t.assign(fz_observed_N=1e-300 * t.fz_observed_N), TactileDataError, "varies by 1.*e-299 only",
    ),
    "a perfect prediction": (
        lambda t: t.assign(fz_observed_N=2 * t.fz_predicted_N).drop(columns="fz_noise_N"), TactileDataError, "exactly",
    ),
    "a perfect prediction, its noise stated": (
        lambda t: t.assign(fz_observed_N=t.fz_predicted_N), TactileDataError, "exactly",
    ),
    "words among numbers": (
        lambda t: t.assign(fz_observed_N=t.fz_observed_N.astype(object).where(t.index != 3, "broken")),
        TactileDataError, "'broken'",
    ),
    "nothing but gaps": (lambda t: t.assign(fz_observed_N=np.nan), TactileDataError, "no row"),
    "noise of 0": (lambda t: t.assign(fz_noise_N=0.0), TactileDataError, "is 0 somewhere"),
    "different units": (lambda t: t.rename(columns={"fz_observed_N": "fz_observed_kN"}), UsageError, "units"),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_bad_tables_are_answered_in_words(what):
    """Each with its own error, which names what was found."""
    spoil, kind, words = BAD[what]
    with pytest.raises(kind, match=words):
        residuals_of(spoil(presses()))


def test_files_that_are_no_tables(tmp_path):
    """Files that are missing, of another kind, empty or torn are refused."""
    with pytest.raises(MissingFile):
        read_table(tmp_path / "nowhere.csv")
    (tmp_path / "notes.txt").write_text("hello")
    with pytest.raises(UsageError, match="no table"):
        read_table(tmp_path / "notes.txt")
    (tmp_path / "empty.csv").write_text("a,b\n")
    with pytest.raises(TactileDataError, match="no rows"):
        read_table(tmp_path / "empty.csv")
    for name in ("void.csv", "torn.parquet"):
        (tmp_path / name).write_bytes(b"")
        with pytest.raises(TactileDataError, match="cannot be read"):
            read_table(tmp_path / name)


def test_gaps_are_left_out_and_said():
    """A few rows without a number go; a covariate that is mostly empty goes instead of its rows."""
    table = presses()
    table.loc[:4, "fz_observed_N"] = np.nan
    table.loc[7, "depth_mm"] = np.inf
    table["humidity"] = np.where(table.index < 100, 0.5 + 0.001 * table.index, np.nan)
    table["mass_kg"] = 0.3
    read = residuals_of(table)
    assert len(read.residuals.values) == len(table) - 6
    assert "humidity" not in read.residuals.covariates
    notes = " ".join(read.notes)
    for words in ("6 rows", "humidity is left out: ", "rows are empty, or beyond", "mass_kg"):
        assert words in notes


def test_long_tables_are_thinned_and_it_is_said():
    """Every other row of each group is kept, its first one always."""
    table = presses(0, 100, 210)
    read = residuals_of(table)
    assert len(read.residuals.values) == 100 * 105
    np.testing.assert_allclose(read.residuals.covariates["time"].values[:3], [0.0, 0.2, 0.4])
    assert "one row of 2" in " ".join(read.notes)


@pytest.mark.slow
def test_groups_of_one_row_are_enough(tmp_path):
    """A table without inner structure: the rate is found; the floor is zero then, and that is said."""
    table = presses(1, 200, 5, rate=0.2, noise=False).groupby("trial").nth(2)
    _, explanation, document = diagnose_table(saved(tmp_path, table))
    assert explanation.located.leading[0].covariate == "speed"
    assert "zero" in document["gap"]["floor_is"]


@pytest.mark.parametrize(("end", "is_said"), [("\n", False), ("\r\n", False), ("", True)])
@pytest.mark.parametrize("ending", ["csv", "tsv"])
def test_a_last_line_without_its_end_is_said(tmp_path, end, is_said, ending):
    """A file that was cut inside its last number reads as a whole one: nobody can tell, and the notes say so."""
    path = tmp_path / f"presses.{ending}"
    text = presses().to_csv(index=False, sep="," if ending == "csv" else "\t")
    path.write_bytes((text.rstrip("\n") + end).encode())
    assert len(read_table(path)) == len(presses())
    assert [f"the last line of presses.{ending} has no line end" in note for note in doubts_of(path)] == [
        True
    ] * is_said
    presses().to_parquet(tmp_path / "presses.parquet")
    assert not doubts_of(tmp_path / "presses.parquet")


def test_a_doubt_of_the_file_stands_among_the_notes(tmp_path):
    """The notes of the answer begin with it."""
    path = tmp_path / "presses.csv"
    path.write_text(presses(trials=12).to_csv(index=False).rstrip("\n"))
    assert "has no line end" in diagnose_table(path)[0].notes[0]


def test_rows_that_stand_twice_count_once():
    """A table that was saved twice into one file gives what it gives once, and says so; without times nothing is left
    out, as equal readings may be two.
    """
    once = presses(0, noise=False).drop(columns="fz_noise_N", errors="ignore")
    twice = pd.concat([once, once.sample(frac=1.0, random_state=3)], ignore_index=True)
    read, doubled = residuals_of(once), residuals_of(twice)
    assert (read.residuals.values == doubled.residuals.values).all()
    assert read.notes == tuple(note for note in doubled.notes if "the same time" not in note)
    [note] = [note for note in doubled.notes if "the same time" in note]
    assert note.startswith(f"{len(once)} rows of {len(twice)} left out")
    untimed = residuals_of(twice.drop(columns="time_s"))
    assert len(untimed.residuals.values) == len(twice)


def test_strays_are_left_out_and_said():
    """One reading a billion times too large; readings that are merely large stay."""
    table = presses(0)
    table.loc[7, "fz_observed_N"] = 1e9
    table.loc[9, "fz_observed_N"] += 1.0
    read = residuals_of(table)
    assert len(read.residuals.values) == len(table) - 1
    assert "first: 7" in " ".join(read.notes)
    table = presses(0)
    half = table.assign(fz_observed_N=table.fz_observed_N + np.where(table.index % 2, 100.0, 0.0))
    assert len(residuals_of(half).residuals.values) == len(table)


ODD = {
    "a separator at the end of each row": (
        lambda text: text.replace("\n", ",\n").replace(",\n", "\n", 1),
        "more fields",
    ),
    "a column twice": (lambda text: text.replace("depth_mm", "fz_observed_N", 1), "twice"),
    "a time in words": (lambda text: text.replace(",0.1,", ",12:30,", 1), "12:30"),
    "semicolons": (lambda text: text.replace(",", ";"), "semicolons"),
    "a column without a name": (lambda text: text.replace("depth_mm", " ", 1), "has no name"),
    "zero bytes": (lambda text: text.replace("\n", "\n\0", 3), "zero bytes"),
    "an escape in a name": (lambda text: text.replace("depth_mm", "dep\x1b[31mth_mm", 1), "cannot be printed"),
}


@pytest.mark.parametrize("what", ODD)
def test_files_that_would_be_misread_are_refused(what, tmp_path):
    """A file that would be misread is refused with its cause."""
    spoil, words = ODD[what]
    path = saved(tmp_path, presses())
    path.write_text(spoil(path.read_text()))
    with pytest.raises(TactileDataError, match=words):
        residuals_of(read_table(path))


def test_moments_and_decimals_are_numbers(tmp_path):
    """A Parquet file with an index of groups, moments and decimals is read as the plain one."""
    table = presses()
    moments = pd.Timestamp("2026-01-01") + pd.to_timedelta(table.time_s, unit="s")
    depths = [decimal.Decimal(str(one)) for one in table.depth_mm.round(6)]
    odd = table.assign(time_s=moments, depth_mm=depths).set_index("trial")
    odd.to_parquet(tmp_path / "odd.PARQUET")
    found, plain = (residuals_of(one).residuals for one in (read_table(tmp_path / "odd.PARQUET"), table))
    for name in ("time", "depth"):
        np.testing.assert_allclose(found.covariates[name].values, plain.covariates[name].values, atol=1e-6)
    np.testing.assert_allclose(found.values, plain.values)


def test_a_column_means_one_thing_and_numbers_are_sane():
    """A column with two meanings, and a noise correlation that is no usable number, are refused."""
    quantities = {"fz": {"observed": "fz_observed_N", "predicted": "fz_predicted_N"}}
    document = {"format": "tactiledata-columns/1", "group": "trial", "quantities": quantities}
    twice = {"covariates": {"depth": {"column": "fz_observed_N"}}}
    with pytest.raises(UsageError, match="two things"):
        residuals_of(presses(), {**document, **twice})
    with pytest.raises(UsageError, match="two things"):
        residuals_of(presses(), group="fz_observed_N")
    for bad in (float("nan"), float("inf"), 1e-300):
        with pytest.raises(UsageError, match="finite number"):
            residuals_of(presses(), {**document, "noise_correlation": bad})


@pytest.mark.slow
def test_a_planted_rate_is_explained(tmp_path):
    """The answer names the scale, the speed and the coefficient; held-out groups fit; nothing is left."""
    table, explanation, document = diagnose_table(saved(tmp_path, presses(1, 50, rate=0.08)))
    assert document["answer"] == "explained"
    first = document["open_form"]["terms"][0]
    assert first["term"] == "log10(speed/(1.0 mm/s))"
    assert abs(first["coefficient"] - 0.08) < max(first["half_width"], 0.008)
    assert explanation.located.leading[0].covariate == "speed"
    assert document["gap"]["closed"] > 0.7
    assert document["gap"]["interval"][0] > 0.5
    assert document["errors"][0]["after"] < document["errors"][0]["before"]
    assert not document["left_over"]["is_structured"]
    frame = presses(1, 50, rate=0.08)
    (said,) = (one for one in document["sentences"] if one.startswith("All refitted together: "))
    formula = re.sub(r"(\d) N", r"\1", said.split(" = ")[1].removesuffix(".")).replace("×", "*")
    words = {"fz": frame.fz_predicted_N, "log10": np.log10, "speed": frame.speed_mm_per_s}
    formula = formula.replace("speed/(1.0 mm/s)", "speed").replace("predicted fz", "fz")
    assert np.std(frame.fz_observed_N - eval(formula, {"__builtins__": {}}, words)) < 1.1 * 0.1
    page, kept = write_diagnosis(tmp_path / "out" / "deep", "table.csv", table, explanation, document)
    assert json.loads(kept.read_text()) == document
    text = page.read_text()
    for words in ("explains it", DEPENDENCE_CAPTION, "How much better", "image/png"):
        assert words in text


@pytest.mark.slow
def test_without_the_noise_it_is_found_too(tmp_path):
    """The scatter from row to row is the floor then, and the size of the residual proves nothing."""
    _, explanation, document = diagnose_table(saved(tmp_path, presses(1, 50, rate=0.08, noise=False)))
    assert document["answer"] == "explained"
    assert "size of the residual" not in document["located"]["p"]
    assert "row to row" in document["gap"]["floor_is"]
    assert explanation.located.gate is None


@pytest.mark.slow
def test_nothing_is_a_first_class_answer(tmp_path):
    """Correlated noise with scales of its own in each trial gives the plain answer that nothing was found."""
    _, _, document = diagnose_table(saved(tmp_path, presses(5, 40)))
    assert document["answer"] == "nothing found"
    assert document["sentences"][0].startswith("Nothing found")
    assert document["open_form"] is None
    assert document["gap"] is None


@pytest.mark.slow
def test_a_common_factor_is_a_calibration(tmp_path):
    """A scale 5 % off throughout is said as such, with its size."""
    table = presses(3, 40)
    table["fz_observed_N"] *= 1.05
    _, explanation, document = diagnose_table(saved(tmp_path, table))
    assert explanation.located.by_table["a common offset"][0].parameter == "the scale of fz"
    assert any("throughout" in sentence for sentence in document["sentences"])


@pytest.mark.slow
def test_the_same_table_gives_the_same_document(tmp_path):
    """The same table gives the same document byte for byte."""
    path = saved(tmp_path, presses(4, 20, rate=0.1))
    one, other = (json.dumps(diagnose_table(path, seed=5)[2]) for _ in range(2))
    assert one == other


@pytest.mark.nightly
def test_empty_tables_are_rarely_called_structured(tmp_path):
    """Of 100 empty tables without known noise, at most one in twenty is called structured."""
    from tactiledata.diagnose.locate.locate import LocateOptions, locate

    alarms = [
        locate(residuals_of(presses(seed, 24, 10, noise=False)).residuals, LocateOptions(seed=seed)).is_structured
        for seed in range(100)
    ]
    assert sum(alarms) <= 5 + 7


def test_a_compressed_file_is_to_be_unpacked(tmp_path):
    """The message about a compressed table says to unpack it, and not to save it as UTF-8."""
    (tmp_path / "presses.csv").write_bytes(gzip.compress(b"a,b\n1,2\n"))
    with pytest.raises(TactileDataError, match="It is compressed: unpack it"):
        read_table(tmp_path / "presses.csv")


def test_a_partner_that_is_missing_is_not_taken_from_the_other_side():
    """An observed column is not suggested as the near name of a predicted one; a typing error is."""
    table = presses(3, 4).drop(columns="fz_predicted_N")
    with pytest.raises(UnknownName, match="fz_observed_N has no partner") as told:
        residuals_of(table)
    assert "Did you mean" not in str(told.value)


@pytest.mark.parametrize(
    ("times", "word"),
    [
        (lambda rows: 0.0, "left out, as they never change: time_s"),
        (lambda rows: np.nan, "column time_s is left out: 100 % of its rows are empty"),
        (lambda rows: np.where(rows % 4 == 0, -rows, np.nan), "column time_s is left out: 75 % of its rows are empty"),
    ],
)
def test_a_time_that_says_nothing_is_no_time(times, word):
    """A time that is empty or never changes is left out with a note: rows keep their order, and no memory fades."""
    table = presses(trials=10)
    found = residuals_of(table.assign(time_s=times(np.arange(len(table)))))
    assert any(word in note for note in found.notes)
    assert found.columns.time is None
    np.testing.assert_array_equal(found.residuals.covariates["depth"].values, table["depth_mm"])
    names = [atom.name for atom in atoms(found.residuals, found.columns.scales, found.columns.time)]
    assert any("so far" in name for name in names)
    assert not any("remembered" in name for name in names)
