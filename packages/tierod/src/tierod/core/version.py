"""The version of tierod, which files and results state."""

__version__ = "0.1.0"
