"""Transfer between sensors by arithmetic on pixels: what a learned model has to beat; one file each, one line each."""

from tactiledata.registry import Registry

PIXEL_TRANSFERS = Registry(
    "transfer method",
    {
        "no_contact": "split_models.pixel_transfer.no_contact:NO_CONTACT",
        "background_swap": "split_models.pixel_transfer.background_swap:BACKGROUND_SWAP",
        "background_ratio": "split_models.pixel_transfer.background_ratio:BACKGROUND_RATIO",
        "histogram_matching": "split_models.pixel_transfer.histogram_matching:HISTOGRAM_MATCHING",
        "reinhard": "split_models.pixel_transfer.reinhard:REINHARD",
        "fourier": "split_models.pixel_transfer.fourier:FOURIER",
    },
    group="split_models.pixel_transfer",
)
"""Methods by name; each is a ``PixelTransfer``."""
