"""tierod: estimate what cannot be measured in a steering system, and find what is going wrong in it."""

__version__ = "0.1.0"
