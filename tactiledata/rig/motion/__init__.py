"""How the arm and the indenter move."""
