"""Rendering only: data in, one page or picture that a person wants to read out."""
