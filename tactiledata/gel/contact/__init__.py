"""Unilateral contact with friction along the path of an indenter."""
