"""Monitors on control units and in simulators: C99 with its evidence, and functional mock-up units."""
