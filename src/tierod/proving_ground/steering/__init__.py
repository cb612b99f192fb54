"""Steerings of the virtual cars: from the steering wheel to the road wheels."""
