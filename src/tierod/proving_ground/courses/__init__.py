"""Courses: demands on a virtual car and its driver over time or distance, with road and wind.

course = load("city")
course = replace(course, seed=3, time=600.0)
"""

from tierod.proving_ground.courses.catalogue import AnyCourse, described, from_document, load, shipped
from tierod.proving_ground.courses.course import Columns, Course, Start

__all__ = ["AnyCourse", "Columns", "Course", "Start", "described", "from_document", "load", "shipped"]
