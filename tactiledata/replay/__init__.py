"""Recorded trajectories played through the soft gel: a mesh, a contact and a wrench for every frame of a store."""
