"""Models for monitors: stateless equations of state and output, composed of `tierod.physics`."""
