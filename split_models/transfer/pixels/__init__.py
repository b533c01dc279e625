"""Transfer between sensors by arithmetic on pixels: what a learned model has to beat; one file each, one line each."""

from tactiledata.registry import Registry

PIXEL_TRANSFERS = Registry(
    "transfer method",
    {
        "no_contact": "split_models.transfer.pixels.no_contact:NO_CONTACT",
        "background_swap": "split_models.transfer.pixels.background_swap:BACKGROUND_SWAP",
        "background_ratio": "split_models.transfer.pixels.background_ratio:BACKGROUND_RATIO",
        "histogram_matching": "split_models.transfer.pixels.histogram_matching:HISTOGRAM_MATCHING",
        "reinhard": "split_models.transfer.pixels.reinhard:REINHARD",
        "fourier": "split_models.transfer.pixels.fourier:FOURIER",
    },
    group="split_models.transfer.pixels",
)
"""Methods by name; each is a ``PixelTransfer``."""
