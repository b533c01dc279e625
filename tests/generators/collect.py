"""A sink for tests that keeps what it is given."""


class Collected:
    """Images in the order in which they came."""

    def __init__(self):
        self.images = []

    def add(self, image):
        """Keep one image."""
        self.images.append(image)

    def of(self, camera):
        """The images of one camera."""
        return [image for image in self.images if image.camera == camera]


def read(form, path, mapping=None):
    """Every source of a path, read: a list of (recording, images)."""
    taken = []
    for source in form.sources(path):
        sink = Collected()
        taken.append((form.read(source, sink, mapping), sink))
    return taken


def codes(recording):
    """The codes of a recording's findings."""
    return {finding.code for finding in recording.findings}
