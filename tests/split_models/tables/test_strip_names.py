"""Strips of pictures lie in the folder of tables, whatever sensors are called."""

from types import SimpleNamespace

import numpy as np

from split_models.tables import alignment_pictures


def test_a_sensor_named_like_a_path_leaves_no_folder(tmp_path, monkeypatch):
    """Slashes and leading dots of a serial become part of the file's name; plain serials stay as they are."""
    monkeypatch.setattr(alignment_pictures, "_strip", lambda *_: np.zeros((2, 2, 3), np.uint8))
    folder = tmp_path / "1" / "tables"
    table = SimpleNamespace(
        sources=["../../../up"], targets={"A": "D1", "B": "../x"}, recipe_run=SimpleNamespace(tables=folder)
    )
    alignment_pictures.write_strips(table)
    written = {path.relative_to(tmp_path).parent.as_posix() for path in tmp_path.rglob("*.png")}
    assert written == {"1/tables"}
    assert len(list(folder.iterdir())) == 4
    table.sources = ["D0"]
    alignment_pictures.write_strips(table)
    assert (folder / "strip-D0-D1.png").exists()
