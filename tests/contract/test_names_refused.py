"""Names that documents may not hold are refused in words, wherever they stand."""

import pytest

from tactiledata.contract.schema import check_document
from tactiledata.errors import SchemaError

LOG = {"format": "tactiledata-log/1", "sensors": {"D1": {"model": "digit"}}}


@pytest.mark.parametrize("name", ["Gel/A", "/", "a\\b", "a\nb", "   ", ""])
@pytest.mark.parametrize("place", ["mapping", "sensors", "indenters"])
def test_a_slash_in_a_name_is_refused_in_words(name, place):
    """A slash is refused in a mapping as in a log.yaml (decision 0043); no regular expression is shown."""
    if place == "mapping":
        document, schema = (
            {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": "/x", "sensor": name}}},
            place,
        )
    else:
        document, schema = (
            {**LOG, place: {name: {"model": "digit"} if place == "sensors" else {"shape": "sphere"}}},
            "log",
        )
    with pytest.raises(SchemaError) as caught:
        check_document(document, schema, "run.yaml")
    assert "[^" not in str(caught.value)
    assert not name or "names hold no slash" in str(caught.value)


@pytest.mark.parametrize("name", ["Gel-A", "D 20542", "GelA@2", "Prüfung-测试"])
def test_other_names_are_taken(name):
    """Negative control: blanks between, dashes, at signs and letters of other scripts are names."""
    check_document(
        {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": "/x", "sensor": name}}}, "mapping", ""
    )
    check_document({**LOG, "sensors": {name: {"model": "digit"}}}, "log", "")
