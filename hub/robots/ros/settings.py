"""Lights and joints of a robot with ROS: numbers that are set by topics or services."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from hub.robots.description import RobotDescription
from hub.robots.ros.commands import setting_payload
from hub.robots.ros.line import RosLine
from hub.robots.ros.services import RosServices
from hub.robots.vehicle_tables import JointTable

_PERIOD_S: Final = 0.05
"""Time between two angles of a joint that turns [s]."""


class RosSettings:
    """The lights and joints of one body."""

    def __init__(self, robot: RobotDescription, line: RosLine, services: RosServices) -> None:
        self._line, self._services = line, services
        self._lights = {each.name: each.topic for each in robot.lights if each.topic}
        self._joints = {each.name: each for each in robot.joints if each.topic}
        self._brightness: dict[str, float] = {}
        self._rates: dict[str, float] = {}
        self._angles: dict[str, float] = {}
        self._waiting: dict[str, float] = {}
        self._advertised: dict[str, str] = {}
        self._since = 0.0

    def brightness(self, name: str) -> float:
        """What the brightness of a light was set to."""
        return self._brightness.get(name, 0.0)

    def set_light(self, name: str, brightness: float) -> None:
        """Set the brightness of a light; a light without a topic does nothing."""
        topic = self._lights.get(name)
        if topic is None:
            return
        self._brightness[name] = brightness
        if topic in self._line.graph.services:
            self._services.switch(topic, on=brightness > 0.0)
        else:
            self._waiting[topic] = brightness

    def turn_joint(self, name: str, rate: float, angles: Mapping[str, float]) -> None:
        """Turn a joint from its present angle on [rad/s, rad]."""
        if name not in self._joints:
            return
        if rate and not self._rates.get(name):
            angle = angles.get(name, math.nan)
            self._angles[name] = angle if math.isfinite(angle) else self._angles.get(name, 0.0)
        self._rates[name] = rate

    def advance(self, seconds: float) -> None:
        """Turn what turns, and send what waits."""
        self._since += seconds
        if self._since >= _PERIOD_S:
            for name, rate in self._rates.items():
                if rate:
                    self._turn(self._joints[name], rate * self._since)
            self._since = 0.0
        topics = (*self._lights.values(), *(each.topic for each in self._joints.values()))
        for topic in topics:
            self._advertise(topic)
        self._waiting = {
            topic: value for topic, value in self._waiting.items() if not self._send(topic, value)
        }

    def _turn(self, joint: JointTable, angle: float) -> None:
        wanted = self._angles[joint.name] + angle
        self._angles[joint.name] = max(joint.lowest, min(joint.highest, wanted))
        self._waiting[joint.topic] = self._angles[joint.name]

    def _advertise(self, topic: str) -> None:
        found = self._line.graph.topics.get(topic)
        if found is not None and self._advertised.get(topic) != found.schema_name:
            if topic in self._advertised:
                self._line.unadvertise(topic)
            self._advertised[topic] = found.schema_name
            self._line.advertise(topic, found.schema_name)

    def _send(self, topic: str, value: float) -> bool:
        """Send a number; returns whether nothing is left to do."""
        encoding = self._line.encoding(topic) if topic in self._advertised else ""
        if not encoding or not self._line.state.up:
            return False
        payload = setting_payload(self._advertised[topic], value, encoding)
        return payload is None or self._line.publish(topic, payload)
