"""Names that documents give never lead out of their folder."""

from pathlib import PurePosixPath

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.contract.paths import need_file_name, path_inside
from tactiledata.errors import UnsafeContent, UsageError

PARTS = st.sampled_from(["a", "b.png", ".", "..", "", "in", "out", "loop", "C:", "~", "...", " ", "é"])
NAMES = st.lists(PARTS, max_size=6).flatmap(
    lambda parts: st.sampled_from(["/".join(parts), "\\".join(parts), "/" + "/".join(parts)])
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with links: ``in`` to its own ``a``, ``out`` to its parent, ``loop`` to itself."""
    root = tmp_path_factory.mktemp("paths") / "log"
    (root / "a").mkdir(parents=True)
    (root / "in").symlink_to(root / "a")
    (root / "out").symlink_to("..")
    (root / "loop").symlink_to("loop")
    return root


@given(name=NAMES | st.text(max_size=30))
def test_a_path_stays_inside_or_is_refused(folder, name):
    """Whatever the name is, the path lies in the folder once all links are followed, or there is an error."""
    try:
        path = path_inside(folder, name, "log.yaml")
    except UnsafeContent as error:
        assert error.facts["path"] == name  # noqa: PT017
        return
    assert path.resolve().is_relative_to(folder.resolve())
    assert ".." not in PurePosixPath(name.replace("\\", "/")).parts


@pytest.mark.parametrize(
    "name",
    [
        "/etc/passwd",
        "../x",
        "a/../../x",
        "a/..",
        "..\\x",
        "C:\\x",
        "c:/x",
        "\\\\server\\x",
        "out/x",
        "a/\0b",
        "out",
        "loop",
    ],
)
def test_ways_out_are_refused(folder, name):
    """Absolute names, parents, drives, shares, links and zero bytes are refused, with the name in the message."""
    with pytest.raises(UnsafeContent, match=r"log\.yaml names the path"):
        path_inside(folder, name, "log.yaml")


@pytest.mark.parametrize("name", ["a/x.png", "in/x.png", "./a", "a//b", "a\\b.png", "not/there/yet", "...", "a..b"])
def test_names_inside_are_given(folder, name):
    """Names below the folder are taken, there or not, also through a link that stays inside."""
    assert path_inside(folder, name, "log.yaml").is_relative_to(folder)


@pytest.mark.parametrize("name", ["a" * 256, "é" * 128, "/".join(["ab"] * 1200), "a\ud800.png", "b/" + "c" * 5000])
def test_names_that_no_file_can_have_are_refused(folder, name):
    """A name too long for the system, or with half a character, is refused in words that do not repeat all of it."""
    with pytest.raises(UnsafeContent, match="No file can have that name") as caught:
        path_inside(folder, name, "log.yaml")
    assert len(str(caught.value)) < 500


def test_the_longest_names_are_taken(folder):
    """The longest name that a file can have is no fault."""
    assert path_inside(folder, "a" * 255, "log.yaml").name == "a" * 255


@given(name=NAMES | st.text(max_size=70))
def test_a_given_name_is_one_file_name_or_is_refused(name):
    """A name that is accepted is the last part of its own path, in letters that every file system takes."""
    try:
        assert need_file_name(name, "mesh", "low") == name
    except UsageError as error:
        assert f"the mesh name {name!r} cannot be a file name" in str(error)  # noqa: PT017
        return
    assert PurePosixPath(name).parts == (name,)
    assert name.isascii()
    assert name.strip(".") == name


@pytest.mark.parametrize("name", ["default", "low-linear", "9_a-B", "x" * 64])
def test_usual_names_are_taken(name):
    """Negative control: what commands call splits and meshes by themselves is a name."""
    assert need_file_name(name, "split", "default") == name
