#!/usr/bin/env python3
"""Writes reef_knot.h5, the ropes of reef_knot.toml: two tubes around the curves of a loose reef knot."""
import os

import h5py
import numpy as np

RADIUS = 0.005  # m, of the ropes
AROUND, ALONG = 8, 121  # vertices
LENGTH = 0.22  # m, from the middle of the knot to the ends

# The curve of one rope (m). Both of its ends come in under the bight of the other rope, pass over its legs,
# and the bight passes under them. The second rope is the first, turned by half a turn about y: each rope
# holds both ends of the other one on the same side.
HALF = np.array([
    [-LENGTH, 0.011, 0.0], [-0.13, 0.011, -0.003], [-0.075, 0.011, -0.011], [-0.035, 0.014, -0.002],
    [0.0, 0.024, 0.0105], [0.035, 0.035, 0.002], [0.062, 0.030, -0.009], [0.075, 0.0, -0.011]])
A = np.vstack([HALF, HALF[-2::-1] * np.array([1, -1, 1])])


def curve(points, count):
    """Points at equal distances on the Catmull-Rom spline through `points`."""
    p = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    fine = []
    for i in range(1, len(p) - 2):
        for t in np.linspace(0, 1, 200, endpoint=False):
            fine.append(0.5 * (2 * p[i] + (p[i + 1] - p[i - 1]) * t
                               + (2 * p[i - 1] - 5 * p[i] + 4 * p[i + 1] - p[i + 2]) * t**2
                               + (3 * p[i] - p[i - 1] - 3 * p[i + 1] + p[i + 2]) * t**3))
    fine = np.array(fine + [points[-1]])
    for _ in range(400):  # rounds off the corners of the spline
        fine[1:-1] += 0.5 * (0.5 * (fine[:-2] + fine[2:]) - fine[1:-1])
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    return np.stack([np.interp(np.linspace(0, way[-1], count), way, fine[:, k]) for k in range(3)], 1)


def tube(points):
    """Positions [along, around, 3] of a tube without twist."""
    tangent = np.gradient(points, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    normal = np.array([0.0, 0.0, 1.0])
    rows = []
    for x, t in zip(points, tangent):
        normal = normal - normal.dot(t) * t
        normal /= np.linalg.norm(normal)
        across = np.cross(t, normal)
        angles = 2 * np.pi * np.arange(AROUND) / AROUND
        rows.append([x + RADIUS * (np.cos(a) * normal + np.sin(a) * across) for a in angles])
    return np.array(rows)


if __name__ == "__main__":
    one = curve(A, ALONG)
    other = one * np.array([-1, 1, -1])
    with h5py.File(os.path.join(os.path.dirname(__file__), "reef_knot.h5"), "w") as file:
        file["one"] = tube(one).astype("f4")
        file["other"] = tube(other).astype("f4")
    # The distance of the two curves must exceed the diameter of the ropes, their thickness and range.
    apart = np.linalg.norm(one[:, None] - other[None], axis=2).min()
    middle = len(one) // 2
    own = np.linalg.norm(one[:, None] - one[None], axis=2)
    far = np.abs(np.arange(len(one))[:, None] - np.arange(len(one))[None]) > 12
    print(f"least distance of the curves {apart:.4f} m, of one with itself {own[far].min():.4f} m; "
          f"{LENGTH:g} m to the ends, {AROUND} x {ALONG} vertices")
