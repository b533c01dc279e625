"""What effects know of a touch, and how the gel answers them."""
