"""Fewer examples of laws whose examples cost much, in the same proportion in `make quick` as in `make test`."""

from hypothesis import settings


def few(examples):
    """Settings with so many examples where `make test` tries 100, and a third of them where `make quick` tries 33."""
    return settings(max_examples=max(1, examples * settings.default.max_examples // 100))
