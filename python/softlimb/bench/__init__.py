"""How fast the package is: what the command ``softlimb bench`` measures and prints."""
