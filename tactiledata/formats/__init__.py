"""Formats in which recordings come: one member a format, one line each in the table below.

``base`` says what a format offers: ``sniff`` judges by content, ``sources`` lists recordings, ``read`` pushes
pictures into a sink and returns signals in SI units, ``inspect`` says what is in a file without keeping it. A
format in one file is ``<name>.py``; ``mcap``, ``folder`` and ``hdf5`` are folders whose member bears the same name.
``reading`` holds what several formats read alike. Members never import one another. Nothing here chooses clocks or
takes off zeros: that is ``ingest``.
"""

from tactiledata.registry import Registry

FORMATS = Registry(
    "log format",
    {
        "mcap": "tactiledata.formats.mcap.mcap:McapFormat",
        "folder": "tactiledata.formats.folder.folder:FolderFormat",
        "rtde_csv": "tactiledata.formats.rtde_csv:RtdeCsvFormat",
        "gelsight_presses": "tactiledata.formats.gelsight_presses:GelsightPressesFormat",
        "ycb_slide": "tactiledata.formats.ycb_slide:YcbSlideFormat",
        "tvl": "tactiledata.formats.tvl:TvlFormat",
        "fota": "tactiledata.formats.fota:FotaFormat",
        "objectfolder_real": "tactiledata.formats.objectfolder_real:ObjectFolderRealFormat",
        "sparsh_force": "tactiledata.formats.sparsh_force:SparshForceFormat",
        "across_hdf5": "tactiledata.formats.across_hdf5:AcrossHdf5Format",
        "hdf5": "tactiledata.formats.hdf5.hdf5:Hdf5Format",
        "image_folder": "tactiledata.formats.image_folder:ImageFolderFormat",
    },
    group="tactiledata.formats",
)
"""In the order in which sniffing tries them: the most specific first."""
