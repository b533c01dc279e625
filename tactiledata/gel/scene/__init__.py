"""A moment of a touch as a MuJoCo scene."""
