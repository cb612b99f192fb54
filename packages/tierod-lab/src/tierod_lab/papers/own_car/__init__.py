"""The study of own cars: brochure values, one drive to identify the car, other drives to judge it."""
