"""Single changes of the source, and whether the tests find them."""
