"""The readings of a case of a proof, as a diagnosis gets them."""

from __future__ import annotations

from tactiledata.prove.seal.folder import ProofFolder, read_readings
from tactiledata.prove.worlds.logs import LogReadings


def case_readings(folder: ProofFolder, name: str) -> list[LogReadings]:
    """Return the readings of each log of a case.

    Parameters
    ----------
    folder : ProofFolder
        The proof.
    name : str
        Name of the case.

    Raises
    ------
    MissingFile
        The case has no file.
    StoreError
        The file is no case of a proof.
    """
    return [LogReadings(*one) for one in read_readings(folder.case(name))]
