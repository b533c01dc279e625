"""Drafts of mappings as a person takes them up: checked, and with paragraphs uncommented; JSON values of any shape."""

import re

from hypothesis import strategies as st

from tactiledata.contract.schema import check_document, parse_document
from tactiledata.formats.mcap.mcap import McapFormat

FORMAT = McapFormat()
NAMES = st.text("abfqtxyz", min_size=1, max_size=4)
VALUES = st.recursive(
    st.floats(-100, 100) | st.integers(-9, 9) | st.booleans() | st.text(max_size=3) | st.lists(st.floats(-9, 9)),
    lambda inner: st.dictionaries(NAMES, inner, max_size=4),
    max_leaves=12,
)


def draft(path):
    """The draft's text, after its document was found to be the same and to fit."""
    [source] = FORMAT.sources(path)
    inspection = FORMAT.inspect(source)
    assert parse_document(inspection.suggested_text, "the draft") == inspection.suggested_mapping
    check_document(inspection.suggested_mapping, "mapping", "the draft")
    return inspection.suggested_text


def paragraphs(text):
    """The draft's parts between empty lines."""
    return text.split("\n\n")


def uncommented(text, wanted=lambda topic: True):
    """The draft with the paragraphs of some topics uncommented and their units filled in, as its first lines say."""
    parts = []
    for part in paragraphs(text):
        match = re.match(r"  # # (\S+): ", part)
        if match and wanted(match[1]):
            part = re.sub(r"^(\s*)# ", r"\1", part, flags=re.MULTILINE)
        parts.append(part)
    text = re.sub(r"""(['"])\?\1""", '"1"', "\n\n".join(parts))
    return re.sub(r"^# (signals|images):$", r"\1:", text, flags=re.MULTILINE)
