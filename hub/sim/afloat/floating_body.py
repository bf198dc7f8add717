"""A rigid body with six degrees of freedom in a fluid: a blimp in air, a robot under water.

Kirchhoff's form of the equations of Fossen 2011 (Handbook of Marine Craft Hydrodynamics, ch. 6).
The body's frame is x forward, y left, z up, with its origin at the centre of buoyancy. The centre
of mass lies `sag` below it, at g. The velocity is v, and v_r relative to the fluid; the turn rate
is w. A is the added mass, J the moments of inertia. The momenta are

    p = m (v + w x g) + A v_r                 l = J w + g x m v

and they change by

    p' = F - w x p                            l' = T - w x l - v x p_body - v_r x A v_r

Forces are thrust, buoyancy less weight, and drag relative to the fluid. The moment of the weight
rights the body. A and J are diagonal: the equations fall into two blocks of two, (surge, pitch) and
(sway, roll), and two single ones. Scalars do for them.
"""

from __future__ import annotations

from hub.gcm.orientation import Quaternion
from hub.sim.afloat.attitude import (
    LEVEL,
    Vector,
    into_body,
    into_world,
    turned,
    up_in_body,
)
from hub.sim.steps import GRAVITY
from hub.values import dataclass

Six = tuple[float, float, float, float, float, float]
"""Along x, y, z and about x, y, z of the body."""
STILL: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
_NO_FLOW: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class HullSpec:
    """The numbers of a body in a fluid.

    Attributes:
        mass: Mass of the body alone [kg].
        volume: Displaced volume [m^3].
        density: Density of the fluid [kg/m^3].
        sag: Centre of mass below the centre of buoyancy [m].
        inertia: About the centre of buoyancy, with that of the moved fluid [kg m^2].
        added: Mass of fluid that moves along, in x, y, z [kg].
        linear: Drag per speed [N s/m] and per turn rate [N m s].
        quadratic: Drag per squared speed [N s^2/m^2] and squared turn rate [N m s^2].
    """

    mass: float
    volume: float
    density: float
    sag: float
    inertia: Vector
    added: Vector
    linear: Six
    quadratic: Six

    @property
    def weight(self) -> float:
        """Force of gravity [N]."""
        return self.mass * GRAVITY

    @property
    def buoyancy(self) -> float:
        """Of the whole volume [N]."""
        return self.density * self.volume * GRAVITY

    def drag(self, axis: int, speed: float) -> float:
        """Force or moment that a steady speed along or about one axis needs [N or N m]."""
        return (self.linear[axis] + self.quadratic[axis] * abs(speed)) * speed


class FloatingBody:
    """A body and its motion.

    Attributes:
        hull: Its numbers.
        position: Of the centre of buoyancy in the world [m].
        attitude: Of the body in the world.
        velocity: Along and about the body's axes [m/s, rad/s].
    """

    def __init__(
        self, hull: HullSpec, position: Vector = (0.0, 0.0, 0.0), attitude: Quaternion = LEVEL
    ) -> None:
        self.hull = hull
        self.position = position
        self.attitude = attitude
        self.velocity: Six = STILL
        self._lever = hull.mass * hull.sag
        self._surge_mass = hull.mass + hull.added[0]
        self._sway_mass = hull.mass + hull.added[1]
        self._heave_mass = hull.mass + hull.added[2]
        self._surge_pitch = self._surge_mass * hull.inertia[1] - self._lever**2
        self._sway_roll = self._sway_mass * hull.inertia[0] - self._lever**2

    def acceleration(
        self,
        velocity: Six,
        attitude: Quaternion,
        thrust: Six,
        flow: Vector = _NO_FLOW,
        submerged: float = 1.0,
    ) -> Six:
        """Rates of change of the velocity [m/s^2, rad/s^2].

        Args:
            velocity: Along and about the body's axes [m/s, rad/s].
            attitude: Of the body.
            thrust: Forces and moments of all thrusters and lines [N, N m].
            flow: Velocity of the fluid in the world [m/s].
            submerged: Share of the volume that displaces fluid, 0 to 1.
        """
        hull = self.hull
        u, v, w, p, q, r = velocity
        m, lever = hull.mass, self._lever
        ax, ay, az = hull.added
        ix, iy, iz = hull.inertia
        cx, cy, cz = into_body(attitude, flow)
        ur, vr, wr = u - cx, v - cy, w - cz
        # Momenta of the body and of the fluid that moves along.
        bx, by, bz = m * u - lever * q, m * v + lever * p, m * w
        ex, ey, ez = ax * ur, ay * vr, az * wr
        px, py, pz = bx + ex, by + ey, bz + ez
        lx, ly, lz = ix * p + lever * v, iy * q - lever * u, iz * r
        kx, ky, kz = up_in_body(attitude)
        lift = hull.buoyancy * submerged - hull.weight
        k, s = hull.linear, hull.quadratic
        fx = thrust[0] + lift * kx - (k[0] + s[0] * abs(ur)) * ur - (q * pz - r * py)
        fy = thrust[1] + lift * ky - (k[1] + s[1] * abs(vr)) * vr - (r * px - p * pz)
        fz = thrust[2] + lift * kz - (k[2] + s[2] * abs(wr)) * wr - (p * py - q * px)
        # A steady flow turns in the frame of a turning body.
        fx -= ax * (q * cz - r * cy)
        fy -= ay * (r * cx - p * cz)
        fz -= az * (p * cy - q * cx)
        righting = hull.weight * hull.sag
        tx = thrust[3] - righting * ky - (k[3] + s[3] * abs(p)) * p - (q * lz - r * ly)
        ty = thrust[4] + righting * kx - (k[4] + s[4] * abs(q)) * q - (r * lx - p * lz)
        tz = thrust[5] - (k[5] + s[5] * abs(r)) * r - (p * ly - q * lx)
        tx -= (v * bz - w * by) + (vr * ez - wr * ey)
        ty -= (w * bx - u * bz) + (wr * ex - ur * ez)
        tz -= (u * by - v * bx) + (ur * ey - vr * ex)
        return (
            (iy * fx + lever * ty) / self._surge_pitch,
            (ix * fy - lever * tx) / self._sway_roll,
            fz / self._heave_mass,
            (self._sway_mass * tx - lever * fy) / self._sway_roll,
            (self._surge_mass * ty + lever * fx) / self._surge_pitch,
            tz / iz,
        )

    def step(
        self, thrust: Six, seconds: float, flow: Vector = _NO_FLOW, submerged: float = 1.0
    ) -> None:
        """Move for a short time by the midpoint rule; 20 ms are short enough for both robots."""
        u, v, w, p, q, r = self.velocity
        half = 0.5 * seconds
        change = self.acceleration(self.velocity, self.attitude, thrust, flow, submerged)
        du, dv, dw, dp, dq, dr = change
        middle: Six = (
            u + half * du,
            v + half * dv,
            w + half * dw,
            p + half * dp,
            q + half * dq,
            r + half * dr,
        )
        attitude = turned(self.attitude, (p, q, r), half)
        du, dv, dw, dp, dq, dr = self.acceleration(middle, attitude, thrust, flow, submerged)
        self.velocity = (
            u + seconds * du,
            v + seconds * dv,
            w + seconds * dw,
            p + seconds * dp,
            q + seconds * dq,
            r + seconds * dr,
        )
        vx, vy, vz = into_world(attitude, (middle[0], middle[1], middle[2]))
        x, y, z = self.position
        self.position = (x + seconds * vx, y + seconds * vy, z + seconds * vz)
        self.attitude = turned(self.attitude, (middle[3], middle[4], middle[5]), seconds)

    @property
    def world_velocity(self) -> Vector:
        """Of the centre of buoyancy in the world [m/s]."""
        u, v, w, _, _, _ = self.velocity
        return into_world(self.attitude, (u, v, w))

    def strike(self, normal: Vector, share: float = 1.0) -> None:
        """Take a push at the centre of buoyancy that ends the motion against a normal.

        The push changes surge and pitch together, and sway and roll, as their inertia is coupled.
        So it never adds energy.

        Args:
            normal: Unit vector in the world, away from what is struck.
            share: Share of the motion that ends, 0 to 1.
        """
        nx, ny, nz = into_body(self.attitude, normal)
        u, v, w, p, q, r = self.velocity
        against = nx * u + ny * v + nz * w
        if against >= 0.0:
            return
        ix, iy, _ = self.hull.inertia
        ease = (
            nx * nx * iy / self._surge_pitch
            + ny * ny * ix / self._sway_roll
            + nz * nz / self._heave_mass
        )
        push = -share * against / ease
        self.velocity = (
            u + push * nx * iy / self._surge_pitch,
            v + push * ny * ix / self._sway_roll,
            w + push * nz / self._heave_mass,
            p - push * ny * self._lever / self._sway_roll,
            q + push * nx * self._lever / self._surge_pitch,
            r,
        )

    def slow_yaw(self, share: float) -> None:
        """Take away a share of the turn rate about the body's z."""
        u, v, w, p, q, r = self.velocity
        self.velocity = (u, v, w, p, q, r * (1.0 - share))
