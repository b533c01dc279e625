"""What the zero of the force sensor follows."""
