"""Models for monitors: equations without memory, put together from `tierod.physics`."""
