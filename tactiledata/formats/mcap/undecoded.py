"""Why a message could not be decoded, in words about the message instead of those of the libraries that read it."""

from __future__ import annotations

import binascii
import json
import struct

from mcap.exceptions import McapError
from rosbags.serde import SerdeError

UNFIT = "its bytes do not fit the type that the recording states for it"
_OF_BYTES = (SerdeError, struct.error, McapError, IndexError, AssertionError)
"""What decoders of binary messages raise where the bytes end too early, or hold lengths that cannot be."""


def reason_of(error: Exception) -> str:
    """Return why a message could not be decoded, as a clause about it.

    Parameters
    ----------
    error : Exception
        What was raised while a message was decoded, or while its fields were read.

    Examples
    --------
    >>> reason_of(IndexError("list index out of range"))
    'its bytes do not fit the type that the recording states for it'
    """
    if isinstance(error, json.JSONDecodeError):
        return f"it is no JSON from character {error.pos + 1} on"
    if isinstance(error, UnicodeDecodeError):
        return f"it is no text from byte {error.start + 1} on"
    if isinstance(error, RecursionError):
        return "it nests too deeply"
    if isinstance(error, binascii.Error):
        return "its pixels are no base64"
    if isinstance(error, _OF_BYTES):
        return UNFIT
    return str(error)
