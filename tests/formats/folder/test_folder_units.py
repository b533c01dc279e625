"""Tables of a folder log in other units than SI: what log.yaml or a mapping states is brought to SI, once."""

import numpy as np
import pytest
import yaml
from generators.collect import codes, read
from generators.folder_log import write

from tactiledata.errors import SchemaError
from tactiledata.formats.folder.folder import FolderFormat
from tactiledata.ingest.pipeline import ingest
from tactiledata.store.read.reader import Store

FORMAT = FolderFormat()
UNITS = {
    "wrench": ["gf", "mN", "N", "N mm", "N m", "Nmm"],
    "tcp": ["mm", "cm", "m", 1, 1, 1, 1],
    "joints": ["deg", "rad", "deg", "deg", "deg", "deg"],
}
FACTORS = {
    "wrench": [9.80665e-3, 1e-3, 1, 1e-3, 1, 1e-3],
    "tcp": [1e-3, 1e-2, 1, 1, 1, 1, 1],
    "joints": np.radians([1, 180 / np.pi, 1, 1, 1, 1]),
}


def stating(log, units):
    """The log, after its log.yaml states units."""
    document = yaml.safe_load((log / "log.yaml").read_text(encoding="utf-8"))
    (log / "log.yaml").write_text(yaml.safe_dump({**document, "units": units}), encoding="utf-8")
    return log


def test_stated_units_are_brought_to_si(tmp_path):
    """Each column has its factor, tables that are not named are kept, and a finding says which were brought to SI."""
    write(tmp_path / "log")
    [(plain, _)] = read(FORMAT, tmp_path / "log")
    [(found, _)] = read(FORMAT, stating(tmp_path / "log", UNITS))
    for name, factors in FACTORS.items():
        np.testing.assert_allclose(found.signals[name].values, plain.signals[name].values * factors, rtol=1e-14)
        assert found.signals[name].units == plain.signals[name].units
    assert {one.stream for one in found.findings if one.code == "units-stated"} == set(UNITS)
    [(one, _)] = read(FORMAT, stating(tmp_path / "log", {"tcp": UNITS["tcp"]}))
    np.testing.assert_array_equal(one.signals["wrench"].values, plain.signals["wrench"].values)
    assert [finding.stream for finding in one.findings if finding.code == "units-stated"] == ["tcp"]


def test_si_units_change_nothing(tmp_path):
    """Units that are those of the columns leave every number and say nothing."""
    write(tmp_path / "log")
    [(plain, _)] = read(FORMAT, tmp_path / "log")
    [(found, _)] = read(FORMAT, stating(tmp_path / "log", {"wrench": ["N"] * 3 + ["N m"] * 3}))
    np.testing.assert_array_equal(found.signals["wrench"].values, plain.signals["wrench"].values)
    assert codes(found) == codes(plain)


def test_a_mapping_may_state_them(tmp_path):
    """A log that must not be changed gets its units from the description of a mapping."""
    write(tmp_path / "log")
    mapping = {"format": "tactiledata-mapping/1", "description": {"units": {"joints": ["deg"] * 6}}}
    [(plain, _)] = read(FORMAT, tmp_path / "log")
    [(found, _)] = read(FORMAT, tmp_path / "log", mapping)
    np.testing.assert_allclose(found.signals["joints"].values, np.radians(plain.signals["joints"].values))


@pytest.mark.parametrize(
    ("units", "words"),
    [
        ({"wrench": ["furlong"] + ["N"] * 2 + ["N m"] * 3}, ("'furlong' for fx", "mN", "$.units.wrench")),
        ({"wrench": ["mm"] * 6}, ("'mm' for fx", "expected 'N'")),
        ({"wrench": ["N"] * 3}, ("$.units.wrench",)),
        ({"camera": ["N"]}, ("$.units",)),
        ({"tcp": ["mm", "mm", "mm", "deg", "deg", "deg", "deg"]}, ("'deg' for qx", "expected '1'")),
    ],
)
def test_units_that_cannot_be_are_refused(units, words, tmp_path):
    """An unknown unit, one of another quantity, too few, and tables that a log does not have are named."""
    write(tmp_path / "log")
    with pytest.raises(SchemaError) as refused:
        read(FORMAT, stating(tmp_path / "log", units))
    said = f"{refused.value} {refused.value.facts.get('path', '')}"
    assert all(word in said for word in words), said


def test_the_store_forgets_stated_units(tmp_path):
    """What is stored is SI, so that a log written from the store does not have its numbers brought to SI again."""
    write(tmp_path / "log")
    ingest([stating(tmp_path / "log", UNITS)], tmp_path / "ds.zarr")
    store = Store.open(tmp_path / "ds.zarr")
    assert "units" not in store.sources(["description"])["description"][0].as_py()
    assert "units-stated" in store.findings()["code"].to_pylist()


@pytest.mark.slow
def test_units_beside_another_format_are_told(tiny_mcaps, tmp_path):
    """Units of tables, stated of an MCAP file, do nothing, and that is said."""
    mapping = {"format": "tactiledata-mapping/1", "description": {"units": {"wrench": ["gf"] * 3 + ["N mm"] * 3}}}
    from tactiledata.ingest.trajectories.assemble import IngestOptions

    ingest([tiny_mcaps[0]], tmp_path / "ds.zarr", IngestOptions(mapping=mapping))
    store = Store.open(tmp_path / "ds.zarr")
    assert "units-not-used" in store.findings()["code"].to_pylist()
    assert '"units"' not in store.sources(["description"])["description"][0].as_py()
