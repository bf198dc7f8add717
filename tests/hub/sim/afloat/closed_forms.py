"""What physics says of a body in a fluid, computed without the simulation."""

from __future__ import annotations

import math

from hub.sim.afloat.attitude import up_in_body
from hub.sim.afloat.floating_body import FloatingBody, HullSpec


def steady_speed(hull: HullSpec, axis: int, thrust: float) -> float:
    """The speed at which drag equals a thrust: the root of l u + q u^2 = F."""
    linear, quadratic = hull.linear[axis], hull.quadratic[axis]
    root = math.sqrt(linear * linear + 4.0 * quadratic * abs(thrust)) - linear
    return math.copysign(root / (2.0 * quadratic), thrust)


def energy(body: FloatingBody) -> float:
    """Kinetic and potential energy of a submerged body in still fluid [J]."""
    hull = body.hull
    u, v, w, p, q, r = body.velocity
    ax, ay, az = hull.added
    ix, iy, iz = hull.inertia
    m, lever = hull.mass, hull.mass * hull.sag
    moving = (m + ax) * u * u + (m + ay) * v * v + (m + az) * w * w
    turning = ix * p * p + iy * q * q + iz * r * r
    coupled = lever * (v * p - u * q)
    rise = (hull.weight - hull.buoyancy) * body.position[2]
    tilt = -hull.weight * hull.sag * up_in_body(body.attitude)[2]
    return 0.5 * (moving + turning) + coupled + rise + tilt
