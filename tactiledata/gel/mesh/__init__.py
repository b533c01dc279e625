"""The pad as a finite-element mesh."""
