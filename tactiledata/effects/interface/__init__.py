"""Effects of friction and adhesion between indenter and gel."""
