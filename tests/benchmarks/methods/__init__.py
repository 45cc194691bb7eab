"""Scenes that break methods, and a count of unstable modes that condenses nothing; the methods are the package's."""
