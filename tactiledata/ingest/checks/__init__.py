"""What is remarked about a recording, before and after it is kept.

- ``checks``: the one entry before a commit; it calls the others.
- ``plausible``, ``units_seen``: stated numbers and signals that are most likely in another unit.
- ``apart``: streams that do not belong together. ``image_sizes``: stray pictures among those of a sensor.
- ``blank_images``: images of one colour. ``background_seen``: images beside the picture without contact.
- ``spooled``: pictures that wait for their commit, read back for these checks.
- ``twins``, ``camera_names``, ``conflicts``: what is known only beside other recordings and the store.
- ``shared_images``: which touches of two recordings hold the same images.
- ``beside``: the entry to these for a whole store, whose own findings it puts before them.
"""
