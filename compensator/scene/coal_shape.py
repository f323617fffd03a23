"""What coal makes of a shape and of a place, and what it tells of two shapes that stand somewhere."""

from __future__ import annotations

from functools import cache
from typing import Any

import coal
import numpy as np
import numpy.typing as npt

from compensator.scene.shape import BoxShape, CapsuleShape, CylinderShape, Shape3

Standing = tuple[Any, Any]  # shape and place, as coal has them
Floats = npt.NDArray[np.float64]


def coal_shape(shape: Shape3) -> Any:
    """Geometry of coal; a mesh with a tree of oriented boxes, as it is: facets, no inside."""
    if isinstance(shape, CapsuleShape):
        return coal.Capsule(shape.radius, shape.length) if shape.length > 0 else coal.Sphere(shape.radius)
    if isinstance(shape, CylinderShape):
        return coal.Cylinder(shape.radius, shape.length)
    if isinstance(shape, BoxShape):
        return coal.Box(*(float(v) for v in shape.size))
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(shape.faces), len(shape.vertices))
    vertices, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for vertex in shape.vertices:
        vertices.append(vertex)
    for a, b, c in shape.faces.tolist():
        triangles.append(coal.Triangle(a, b, c))
    model.addSubModel(vertices, triangles)
    model.endModel()
    model.computeLocalAABB()
    return model


def coal_place(rotation: Floats, origin: Floats) -> Any:
    """Transform of coal."""
    return coal.Transform3s(rotation, origin)


def looked(first: Standing, second: Standing, margin: float) -> tuple[bool, float]:
    """Whether two shapes are within ``margin`` (m) of each other, and a lower bound of their distance where not, m."""
    result = coal.CollisionResult()
    found = coal.collide(*first, *second, _request(margin), result)
    return found > 0, max(float(result.distance_lower_bound), 0.0)


def apart(first: Standing, second: Standing) -> float:
    """Distance of two shapes, m; negative where they touch."""
    return float(coal.distance(*first, *second, coal.DistanceRequest(), coal.DistanceResult()))


@cache
def _request(margin: float) -> Any:
    request = coal.CollisionRequest()
    request.security_margin = margin
    return request
