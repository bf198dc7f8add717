"""The obstacles for a body that stands high or low: a table downstairs is no obstacle upstairs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hub.gcm.body import Bumper
from hub.pose import Pose
from hub.sim.arena import Arena, footprints_of
from hub.sim.contact import NO_IMPACT, ContactBody, Impact
from hub.sim.ground.chassis import Chassis
from hub.sim.ground.height_field import HeightField
from hub.sim.spatial_pose import SpatialPose

STOREY = 0.1
"""Height after which the obstacles are looked up again [m]."""
_HEADROOM = 0.05
"""A deck's lower side may be this little above the ground in front and is still a step [m]."""
_RIM_POINTS = 12


class Storeys:
    """The contact of a body with obstacles at its own height.

    Attributes:
        contacts: Number of new contacts with an obstacle.
    """

    def __init__(
        self,
        arena: Arena,
        field: HeightField,
        chassis: Chassis,
        bumpers: Sequence[Bumper],
        outline: npt.NDArray[np.float64] | None = None,
    ) -> None:
        """Stand at the height of the start.

        Args:
            arena: The obstacles.
            field: The ground.
            chassis: Its height, and its circle.
            bumpers: Its bumpers.
            outline: As of `ContactBody`.
        """
        decks = set(field.deck_boxes)
        self._boxes = tuple(box for box in arena.boxes if box not in decks)
        self._cylinders = arena.cylinders
        self._names = tuple(map(str, range(len(self._boxes) + len(self._cylinders))))
        self._field = field
        self._chassis = chassis
        self._contacts_before = 0
        self._impact = NO_IMPACT
        self._floor: int | None = None
        self._bumpers = bumpers
        self._outline = outline
        self._among = arena.footprints
        self._body = ContactBody(self._among, chassis.reach, bumpers, outline)
        around = np.arange(_RIM_POINTS) * (math.tau / _RIM_POINTS)
        self._rim = np.cos(around) * chassis.reach, np.sin(around) * chassis.reach

    @property
    def touches(self) -> bool:
        """Whether it touches an obstacle."""
        return bool(self._body.touched)

    @property
    def contacts(self) -> int:
        """Number of new contacts with an obstacle."""
        return self._contacts_before + self._body.contacts

    @property
    def impact(self) -> Impact:
        """The last new contact."""
        return self._impact if self._body.impact is NO_IMPACT else self._body.impact

    def bumpers(self, pose: SpatialPose) -> int:
        """Bit i is set when something touches bumper i."""
        return self._body.bumpers(pose.plan)

    def move(self, before: SpatialPose, wanted: Pose) -> Pose:
        """The end of a short motion to a wanted pose in the plane, as `ContactBody.move` has it."""
        floor = math.floor(before.z / STOREY + 0.5)
        if floor != self._floor:
            self._floor = floor
            self._contacts_before += self._body.contacts
            self._impact = self.impact
            touched = {self._among.origin[number] for number in self._body.touched}
            self._among = footprints = footprints_of(
                self._boxes,
                self._cylinders,
                self._names,
                ground=floor * STOREY,
                height=self._chassis.height,
            )
            self._body = ContactBody(footprints, self._chassis.reach, self._bumpers, self._outline)
            # What it touched before is no new contact.
            self._body.touched = frozenset(
                number for number, name in enumerate(footprints.origin) if name in touched
            )
        start = before.plan
        if self._below_a_deck(before, wanted) and not self._below_a_deck(before, start):
            wanted = Pose(x=before.x, y=before.y, theta=wanted.theta)
        return self._body.move(start, wanted)

    def _nears_a_deck(self, at: Pose) -> bool:
        reach = self._chassis.reach
        return any(
            box.low[0] - reach < at.x < box.high[0] + reach
            and box.low[1] - reach < at.y < box.high[1] + reach
            for box in self._field.deck_boxes
        )

    def _below_a_deck(self, pose: SpatialPose, at: Pose) -> bool:
        """Whether a deck there is too low to drive under, and too high to drive onto."""
        decks, undersides = self._field.decks, self._field.undersides
        if decks is None or undersides is None or not self._nears_a_deck(at):
            return False
        x, y = self._rim
        cells = self._field.cells(at.x + x, at.y + y)
        tops, lower = decks.take(cells), undersides.take(cells)
        up = pose.rotation()[:, 2]
        floor = pose.z - (up[0] * x + up[1] * y) / max(float(up[2]), 0.1)
        in_the_way = (tops > floor + _HEADROOM) & (lower < floor + self._chassis.height)
        return bool(in_the_way.any())
