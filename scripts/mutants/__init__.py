"""Mutation testing: single changes of the source, and whether the tests detect them."""
