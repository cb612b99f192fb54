"""Courses: what is asked of a virtual car and its driver, and the road and air around them."""

from tierod.proving_ground.courses.course import Columns, Course, Start

__all__ = ["Columns", "Course", "Start"]
