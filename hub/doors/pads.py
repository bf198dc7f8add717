"""Gamepads that are sent to a robot's hub, and consoles that see the robot in a fleet."""

from __future__ import annotations

from hub.gcm.pad import PAD_DEVICE, PAD_STATE

FOR_CONSOLES = frozenset({PAD_DEVICE.name, PAD_STATE.name})
"""Commands that come from the robot's hub to consoles; consoles send none of them."""
