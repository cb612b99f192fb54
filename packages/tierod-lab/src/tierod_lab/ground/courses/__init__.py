"""Courses: demands on a virtual car and its driver over time or distance, with road and wind.

course = load("city")
course = replace(course, seed=3, time=600.0)
"""

from tierod_lab.ground.courses.catalogue import AnyCourse, described, from_document, load, shipped
from tierod_lab.ground.courses.course import Columns, Course, Start

__all__ = ["AnyCourse", "Columns", "Course", "Start", "described", "from_document", "load", "shipped"]
