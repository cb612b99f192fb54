"""The version of tierod: files and results name it."""

__version__ = "0.1.0"
