"""A sealed document shows the change of any byte; a document without a seal is not taken for a sealed one."""

import hashlib
import json

import pytest

from tactiledata.contract.sealed import SEAL, fits_seal, sealed_json

DOCUMENT = {"name": "ä", "counts": [1, 2.5, None], "zebra": {"b": True}}


def test_the_seal_is_the_digest_of_the_file_with_zeros_in_its_place():
    """64 hexadecimal digits, which are the SHA-256 of the same file with 64 zeros there."""
    content = sealed_json(DOCUMENT)
    seal = json.loads(content)[SEAL]
    assert hashlib.sha256(content.replace(seal.encode(), b"0" * 64)).hexdigest() == seal
    assert {key: value for key, value in json.loads(content).items() if key != SEAL} == DOCUMENT
    assert fits_seal(content)


def test_every_changed_byte_shows():
    """One bit of any byte turned, a byte left out or one added: the seal does not fit."""
    content = sealed_json(DOCUMENT)
    for place in range(len(content)):
        turned = content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]
        assert not fits_seal(turned), place
    assert not fits_seal(content[:-1])
    assert not fits_seal(content + b" ")


@pytest.mark.parametrize(
    "content", [b"", b"{}", b'{\n  "file_sha256": "0"\n}\n', json.dumps({SEAL: "0" * 64}).encode()]
)
def test_a_file_without_a_seal_in_its_place_does_not_fit(content):
    """No seal, a short one, or one on the first line is none."""
    assert not fits_seal(content)


def test_a_seal_that_is_there_is_replaced():
    """A document that is sealed twice has one seal, which fits, whatever the first one was."""
    content = sealed_json({**DOCUMENT, SEAL: "f" * 64})
    assert content == sealed_json(json.loads(sealed_json(DOCUMENT)))
    assert fits_seal(content)


def test_a_field_of_that_name_inside_is_no_seal():
    """Only the document's own field is the seal: inner ones, and texts that look like one, stay as they are."""
    inner = {SEAL: "1" * 64}
    document = {"a": inner, "z": inner, "said": f'\n  "{SEAL}": "{"2" * 64}"'}
    content = sealed_json(document)
    assert {key: value for key, value in json.loads(content).items() if key != SEAL} == document
    assert fits_seal(content)
