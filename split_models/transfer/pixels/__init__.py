"""Transfer between sensors by arithmetic on pixels, which a learned model has to beat.

``base`` defines what a method is: pictures of a source sensor, its background and the target's background in, pictures
in the target's style out. Each other module is one such method and has one line in the table below. From the simplest
to the most elaborate they are ``no_contact``, ``background_swap``, ``background_ratio``, ``relit``, ``reinhard``,
``histogram_matching`` and ``fourier``. ``relight_change`` holds what ``relit`` shares with methods by a model.

A method imports ``base`` and ``relight_change``, and never another method. None of them needs PyTorch, a
store or a file of weights.
"""

from tactiledata.registry import Registry

PIXEL_TRANSFERS = Registry(
    "transfer method",
    {
        "no_contact": "split_models.transfer.pixels.no_contact:NO_CONTACT",
        "background_swap": "split_models.transfer.pixels.background_swap:BACKGROUND_SWAP",
        "background_ratio": "split_models.transfer.pixels.background_ratio:BACKGROUND_RATIO",
        "histogram_matching": "split_models.transfer.pixels.histogram_matching:HISTOGRAM_MATCHING",
        "relit": "split_models.transfer.pixels.relit:RELIT",
        "reinhard": "split_models.transfer.pixels.reinhard:REINHARD",
        "fourier": "split_models.transfer.pixels.fourier:FOURIER",
    },
    group="split_models.transfer.pixels",
)
"""Pixel transfers by name; each is a `PixelTransfer`."""
