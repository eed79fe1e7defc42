"""Qhull as scipy.spatial.Delaunay calls it, with scipy's default options."""
import scipy
import scipy.spatial

import driver

points = driver.points()
made, measured = driver.measure(lambda: scipy.spatial.Delaunay(points))
driver.answer(measured, points, made.simplices, f"scipy {scipy.__version__}")
