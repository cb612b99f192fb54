"""The version of tierod's lab; equal to that of tierod."""

__version__ = "0.1.0"
