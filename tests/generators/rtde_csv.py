"""Small RTDE recordings as UR's recorders write them, and faults to plant into them.

Run as a script to look at one: ``python rtde_csv.py FILE``.
"""

import sys
from pathlib import Path

import numpy as np

VECTORS = ("actual_q", "actual_TCP_pose", "actual_TCP_force")


def write(path, *, rows=50, separator=",", start="48213.002", extra=("actual_digital_input_bits",), seed=0):
    """An RTDE file at 500 Hz; returns times (n,) ns and values (n, 18) as written."""
    rng = np.random.default_rng(seed)
    names = ["timestamp", *(f"{vector}_{axis}" for vector in VECTORS for axis in range(6)), *extra]
    values = rng.uniform(-1, 1, (rows, 18)).round(6)
    seconds, _, milliseconds = start.partition(".")
    first = int(seconds) * 1000 + int(milliseconds)
    times = [first + 2 * row for row in range(rows)]
    lines = [separator.join(names)]
    for time, row in zip(times, values, strict=True):
        cells = [f"{time // 1000}.{time % 1000:03d}", *(repr(float(v)) for v in row), *("0" for _ in extra)]
        lines.append(separator.join(cells))
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return np.array(times) * 10**6, values


if __name__ == "__main__":
    write(sys.argv[1])
