"""The study of cars without preparation: brochure values, one drive to identify, other drives to judge."""
