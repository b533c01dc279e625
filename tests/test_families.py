"""Every member of every family keeps its family's contract; the examples of docs/extending.md are held to it, too."""

import importlib.util
import inspect
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from split_models.transfer.pixels import PIXEL_TRANSFERS
from tactiledata.compute import SCHEDULERS
from tactiledata.effects import EFFECTS
from tactiledata.errors import BrokenLog, TactileDataError, UnknownName
from tactiledata.export import EXPORTERS
from tactiledata.export.base import Exporter
from tactiledata.formats import FORMATS
from tactiledata.formats.base import Format
from tactiledata.indenters import INDENTERS
from tactiledata.metrics import METRICS
from tactiledata.registry import Registry
from tactiledata.sensors import SENSORS

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "tests" / "examples"
TABLES = {
    "formats": FORMATS,
    "indenters": INDENTERS,
    "sensors": SENSORS,
    "compute": SCHEDULERS,
    "effects": EFFECTS,
    "metrics": METRICS,
    "export": EXPORTERS,
    "pixel_transfer": PIXEL_TRANSFERS,
}


def example(name):
    """A module of tests/examples, imported by its path."""
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("family", TABLES)
def test_members_answer_to_their_name(family):
    """The word in a file or recipe, the key in the table and the stem of the member's file are one."""
    table = TABLES[family]
    for name in table:
        module = table._targets()[name].partition(":")[0]
        assert module.rpartition(".")[2] == name
        member = table[name]
        own = getattr(member, "name", None) or getattr(member, "shape", None)
        assert own in (None, name)


@pytest.mark.parametrize("family", TABLES)
def test_unknown_names_list_near_ones(family):
    """A name with a slip of the pen is refused, and the right one is proposed."""
    name = next(iter(TABLES[family]))
    with pytest.raises(UnknownName, match=f"Did you mean.*{name}"):
        TABLES[family][f"{name}x"]


def test_packages_outside_add_members(monkeypatch):
    """An entry point adds a member; one of ours is not replaced."""

    class Point:
        def __init__(self, name, value):
            self.name, self.value = name, value

    points = [Point("extra", "math:pi"), Point("digit", "math:e")]
    monkeypatch.setattr("tactiledata.registry.entry_points", lambda group: points)
    table = Registry("sensor", {"digit": "tactiledata.sensors.digit:DIGIT"}, group="tactiledata.sensors")
    assert list(table) == ["digit", "extra"]
    assert table["extra"] == np.pi
    assert table["digit"].name == "digit"


@pytest.mark.parametrize("name", FORMATS)
def test_formats_describe_themselves(name):
    """A format has a title, a picture of its layout, and a page in the docs that names it."""
    member = FORMATS[name]()
    assert isinstance(member, Format)
    assert member.title
    assert member.layout.strip()
    pages = " ".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("*.md"))
    assert re.search(rf"`{name}`", pages), f"no page in docs/ names `{name}`"


@pytest.mark.parametrize("name", FORMATS)
def test_sniffing_is_never_fooled_into_an_error(name, tmp_path):
    """Random, misnamed and unreadable files are no recording of any format, and no reason to fail."""
    member = FORMATS[name]()
    rng = np.random.default_rng(3)
    (tmp_path / "empty.csv").touch()
    (tmp_path / "random.csv").write_bytes(rng.bytes(5000))
    (tmp_path / "random.npz").write_bytes(b"PK" + rng.bytes(500))
    (tmp_path / "folder.hdf5").mkdir()
    (tmp_path / "words.yaml").write_text("format: something else\n")
    (tmp_path / "dangling.csv").symlink_to(tmp_path / "nowhere")
    for path in [*tmp_path.iterdir(), tmp_path / "nowhere"]:
        assert member.sniff(path) is False, path


@pytest.mark.parametrize("name", EXPORTERS)
def test_exporters_describe_themselves(name):
    """A format of exports has a title, whole sentences on what it loses, and a section in docs/export.md."""
    member = EXPORTERS[name]()
    assert isinstance(member, Exporter)
    assert member.title
    assert member.lost
    assert all(sentence[0].isupper() and sentence.endswith(".") for sentence in member.lost)
    assert f"--to {name}" in (ROOT / "docs" / "export.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", INDENTERS)
def test_indenters_are_in_the_docs(name):
    """Every indenter is described in docs/indenters.md."""
    assert f"`{name}`" in (ROOT / "docs" / "indenters.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", METRICS)
def test_metrics_are_in_the_docs_and_name_their_scores(name):
    """A metric stands in docs/metrics.md with each of its scores, and a score is kept under its own name."""
    member = METRICS[name]
    page = (ROOT / "docs" / "metrics.md").read_text(encoding="utf-8")
    assert f"`{name}`" in page
    for key, score in member.scores.items():
        assert score.name == key
        assert f"`{key}`" in page


def test_the_extending_page_shows_the_examples_as_they_are():
    """docs/extending.md holds the examples to the letter."""
    page = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
    for path in sorted(EXAMPLES.glob("*.py")):
        assert f"`tests/examples/{path.name}`:\n\n```python\n{path.read_text(encoding='utf-8')}```" in page, path.name


def test_the_example_format_goes_into_a_store(tmp_path, monkeypatch):
    """The example format is found by content, its contact becomes a trajectory, and its damage is said."""
    module = example("press_log")
    monkeypatch.setitem(FORMATS._table, "press_log", "press_log:PressLogFormat")
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.store.read.reader import Store

    force = np.zeros(800)
    force[300:500] = 6.0
    rng = np.random.default_rng(0)
    rows = [
        f"{1_700_000_000_000_000_000 + row * 10_000_000} {value:.3f}"
        for row, value in enumerate(force + rng.normal(0, 0.05, 800))
    ]
    rows[100] = "torn"
    (tmp_path / "run.press").write_text("\n".join([module.FIRST_LINE, *rows]))
    report = ingest([tmp_path / "run.press"], tmp_path / "ds.zarr")
    assert report.sources[0].status == "damaged"
    trajectory = Store.open(tmp_path / "ds.zarr").trajectories().to_pylist()[0]
    assert abs(trajectory["peak_force"] - 6.0) < 0.3
    (tmp_path / "none.press").write_text(module.FIRST_LINE)
    member = module.PressLogFormat()
    source = member.sources(tmp_path / "none.press")[0]
    with pytest.raises(BrokenLog, match="no sample"):
        member.read(source, None)


def test_the_example_sensor_is_complete():
    """The example sensor builds, and a number without a source is refused."""
    pad = example("pad_sensor").PAD
    assert pad.camera.pixel_pitch[0] == pytest.approx(0.020 / 240)
    with pytest.raises(TactileDataError, match=r"sources of gel\.outline"):
        type(pad)(pad.name, pad.title, pad.maker, pad.kind, gel=pad.gel)


def test_the_example_indenter_keeps_the_law_of_solids():
    """The example's mesh lies on the zero of its signed distance, and its tip touches first."""
    pin = example("capsule_indenter").Capsule()
    mesh = pin.mesh()
    assert mesh.is_watertight
    assert mesh.bounds[0, 2] == pytest.approx(0, abs=1e-9)
    assert np.abs(pin.signed_distance(mesh.vertices)).max() < 1e-5
    assert pin.height(np.zeros(1), np.zeros(1))[0] == 0


def test_the_example_scheduler_keeps_order():
    """The example's outcomes equal those of one process."""
    tasks = list(range(20))
    scheduler = example("thread_scheduler").ThreadScheduler(3)
    assert [outcome.result for outcome in scheduler.outcomes(str, tasks)] == [str(task) for task in tasks]


def test_the_example_metric_keeps_the_law_of_metrics():
    """The metric is nothing on itself, the worst pixel inside the mask, and no value without one."""
    score = example("largest_error").LARGEST_ERROR.scores["largest"]
    true = np.full((2, 8, 8, 3), 50, np.uint8)
    ours = true.copy()
    ours[:, 2, 2, 1], ours[:, 6, 6, 0] = 90, 20
    assert score(true, true).tolist() == [score.best] * 2
    assert score(ours, true).tolist() == [40, 40]
    mask = np.zeros((2, 8, 8), bool)
    mask[0, 5:, 5:] = True
    np.testing.assert_array_equal(score(ours, true, mask), [30, np.nan])


def test_the_example_exporter_writes_a_table(tiny_store, tmp_path, monkeypatch):
    """A row a touch, and all that an export carries, stand in a folder that the example never sees."""
    example("touch_table")
    monkeypatch.setitem(EXPORTERS._table, "touch_table", "touch_table:TouchTableExporter")
    from tactiledata.export.export import export_data
    from tactiledata.export.plan import ExportPlan
    from tactiledata.store.read.reader import Store

    report = export_data(Store.open(tiny_store), ExportPlan("touch_table"), tmp_path / "out")
    lines = (tmp_path / "out" / "touches.csv").read_text().splitlines()
    assert lines[0] == "trajectory,part,largest_fz_n"
    assert len(lines) == 1 + 4
    assert max(float(line.split(",")[2]) for line in lines[1:]) > 1
    assert set(report.document["files"]) >= {"touches.csv", "README.md", "tactiledata/trajectories.parquet"}


def test_the_error_tree_is_drawn_as_it_is():
    """The tree in errors.py names every class, each with the builtin that it also is."""
    import tactiledata.errors as errors

    for name, member in inspect.getmembers(errors, inspect.isclass):
        if issubclass(member, TactileDataError):
            assert name in errors.__doc__
