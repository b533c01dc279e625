"""Names of strangers are drawn as they stand."""

from tactiledata.report.diagnosis_plots import draw_errors, literal
from tactiledata.report.plots import png_bytes


def test_dollars_are_no_mathematics():
    """Labels with dollar signs and backslashes are drawn as they are, not as mathematics."""
    drawn = draw_errors([r"$\frac$", "a $ b $"], [1.0, 2.0], "times the noise")
    assert png_bytes(drawn).startswith(b"\x89PNG")
    assert literal("a $ b") == r"a \$ b"
