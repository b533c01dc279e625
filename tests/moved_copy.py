"""A copy of a folder log whose times are all moved."""

from pathlib import Path

import pandas as pd
from copied_trees import copy_tree

NS_PER_HOUR = 3_600 * 10**9


def moved_copy(log: Path, place: Path, hours: int) -> Path:
    """Copy a folder log and move every stamp of its tables; its images keep their bytes."""
    copy_tree(log, place)
    with (place / "log.yaml").open("a") as stream:
        stream.write("\n# edited\n")
    for path in place.glob("*.csv"):
        table = pd.read_csv(path)
        for name in [name for name in table.columns if name.endswith("_ns")]:
            table[name] += hours * NS_PER_HOUR
        table.to_csv(path, index=False)
    return place
