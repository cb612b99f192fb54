"""Vehicles that another tool computes: functional mock-up units in place of a virtual car."""
