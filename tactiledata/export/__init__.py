"""Exports: a store written in the formats that others train from or look at.

- ``export``: `export_data`, from a store to a finished folder; start here.
- ``base``: what a format offers. A format is one file and one line in the table below.
- ``find_episodes``, ``episodes``: which trajectories and frames go out, batch by batch. ``pictures``: their bytes.
- ``meanings``: what each stream means, in words. ``plan``: what decides the bytes of an export.
- ``folder``: a folder that is finished or not there, whatever moment the process is killed at.
- ``document``, ``card``, ``tables``: what travels along: `export.json`, a page for people, facts of every recording.
- ``parquet_rows``, ``episode_statistics``, ``recorded_streams``, ``message_types``, ``recording_log``:
  parts of single formats.

A format knows nothing of folders, of being killed, or of the other formats.
"""

from __future__ import annotations

from tactiledata.registry import Registry

EXPORTERS = Registry(
    "format of exported recordings",
    {
        "lerobot": "tactiledata.export.lerobot:LeRobotExporter",
        "huggingface": "tactiledata.export.huggingface:HuggingFaceExporter",
        "webdataset": "tactiledata.export.webdataset:WebDatasetExporter",
        "robomimic": "tactiledata.export.robomimic:RobomimicExporter",
        "mcap": "tactiledata.export.mcap:McapExporter",
    },
    group="tactiledata.exporters",
)
"""Formats of exports by name."""
