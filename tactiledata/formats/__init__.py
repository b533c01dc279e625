"""Formats in which recordings come: one file each, one line each in the table below."""

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
        "image_folder": "tactiledata.formats.image_folder:ImageFolderFormat",
    },
    group="tactiledata.formats",
)
"""In the order in which sniffing tries them: the most specific first."""
