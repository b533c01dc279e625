"""How the pad resists deformation."""
