"""Controllers: how they are designed, the blocks that run them, and the references they follow."""
