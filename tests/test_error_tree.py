"""Errors say what was found, expected and to do; their facts survive the way between processes."""

import copy
import inspect
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata import errors
from tactiledata.errors import BrokenLog, MissingFile, NotAStore, SchemaError, TactileDataError, UnknownName, UsageError

KINDS = [kind for _, kind in inspect.getmembers(errors, inspect.isclass) if issubclass(kind, TactileDataError)]
BUILTINS = {
    "UsageError": ValueError, "UnknownName": KeyError, "MissingSplit": KeyError, "SchemaError": ValueError,
    "BrokenLog": ValueError, "UnsafeContent": ValueError, "MissingFile": FileNotFoundError,
    "LostFile": FileNotFoundError, "StoreError": ValueError, "StoreBusy": BlockingIOError, "LeakError": ValueError,
    "NotAStore": ValueError,
    "CheckpointError": ValueError, "NotFetched": ValueError, "NotFinite": ArithmeticError,
}  # fmt: skip


def made(kind):
    if kind is UnknownName:
        return UnknownName("indenter", "bal", ["ball", "cone"], "Look again.")
    return kind("3 N found", "4 N", "Press harder.", path="$.x", count=3)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("send", [lambda error: pickle.loads(pickle.dumps(error)), copy.copy, copy.deepcopy])
def test_facts_survive_pickling(kind, send):
    """Kind, text, facts and exit code arrive as they left."""
    error = made(kind)
    arrived = send(error)
    assert type(arrived) is kind
    assert str(arrived) == str(error)
    assert arrived.facts == error.facts
    assert arrived.facts
    assert (arrived.found, arrived.expected, arrived.remedy) == (error.found, error.expected, error.remedy)
    assert arrived.exit_code == error.exit_code


def refuse():
    raise SchemaError("bad", "good", "Mend it.", path="$.a", file="log.yaml")


@pytest.mark.slow
def test_facts_come_back_from_a_worker():
    """An error that a worker process raises has its facts in the caller."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool, pytest.raises(SchemaError) as caught:
        pool.submit(refuse).result()
    assert caught.value.facts == {"path": "$.a", "file": "log.yaml"}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_errors_are_builtin_errors_too(kind):
    """Whoever catches ValueError or FileNotFoundError catches ours; wrong calls exit with 2, others with 1."""
    error = made(kind)
    assert kind is TactileDataError or isinstance(error, BUILTINS[kind.__name__])
    assert error.exit_code == (2 if isinstance(error, UsageError | NotAStore) or kind is MissingFile else 1)
    # KeyError and OSError have texts of their own, which must not win
    assert str(error).count(";") == 1
    assert "expected" in str(error)


@pytest.mark.parametrize(
    ("parts", "text"),
    [
        (("a file of 0 bytes", "an MCAP", "Copy it again."), "a file of 0 bytes; expected an MCAP. Copy it again."),
        (("a file of 0 bytes.", "", ""), "a file of 0 bytes."),
        (("empty", "an MCAP.", ""), "empty; expected an MCAP."),
        (("empty", "", "Copy it."), "empty. Copy it."),
    ],
)
def test_the_three_parts_make_one_text(parts, text):
    """Found, expected and remedy are joined with one full stop each."""
    assert str(BrokenLog(*parts)) == text


def test_an_unknown_name_lists_near_ones():
    """A slip of the pen is answered with the names that were meant, and with all that there are."""
    error = UnknownName("indenter", "sphree", ["sphere", "cone", "torus"])
    assert "Did you mean sphere?" in str(error)
    assert "cone, sphere, torus" in str(error)
    assert error.facts["near"] == ["sphere"]
    none = UnknownName("split", "x", [], "`tactiledata split` makes a split.")
    assert str(none) == "unknown split 'x': there is no split. `tactiledata split` makes a split."
    assert "one of: S1, S2." in str(UnknownName("sensor", "nope", ["S2", "S1", "S1"]))


def test_a_proposal_leaves_out_what_is_much_less_alike():
    """One letter too many proposes that one name; two names that are equally near are both proposed."""
    formats = ["huggingface", "lerobot", "mcap", "robomimic", "webdataset"]
    assert UnknownName("format", "lerobott", formats).facts["near"] == ["lerobot"]
    assert UnknownName("sensor", "D2001", ["D20001", "D20011", "ball"]).facts["near"] == ["D20011", "D20001"]


def test_another_number_is_no_misspelling():
    """A number that is not there has no near ones; a digit too few, or a letter, is a slip."""
    names = [f"D20001.mcap/t{number:05d}" for number in range(9)]
    assert UnknownName("trajectory", "t00042", names).facts["near"] == []
    assert UnknownName("trajectory", "D20001.mcap/t00042", names).facts["near"] == []
    assert UnknownName("trajectory", "D2001.mcap/t00004", names).facts["near"][0] == "D20001.mcap/t00004"
    assert UnknownName("trajectory", "D20001.mcap/t0004", names).facts["near"][0] == "D20001.mcap/t00004"


def test_a_remedy_may_be_for_names_that_resemble_none():
    """Who misspelt a name is not told how to make one of the misspelt name."""
    slip, new = (UnknownName("split", name, ["default"], unless_near="Make it.") for name in ("defualt", "by-robot"))
    assert str(slip).endswith("Did you mean default?")
    assert str(new).endswith("Make it.")


def test_many_names_are_not_all_listed():
    """Thirty names are listed, of more the first twelve and their number."""
    few, many = (str(UnknownName("stream", "x", [f"s{n:03d}" for n in range(count)])) for count in (30, 31))
    assert "s029" in few
    assert "… (31 in all)" in many
    assert "s011, …" in many


@given(st.text(), st.text(), st.text(), st.dictionaries(st.text(min_size=1).map(lambda t: f"k{t}"), st.integers()))
def test_any_texts_make_an_error(found, expected, remedy, facts):
    """Whatever the texts hold, the error has a text and travels."""
    error = BrokenLog(found, expected, remedy, **facts)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
    assert error.facts == facts
