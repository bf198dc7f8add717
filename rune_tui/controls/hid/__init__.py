"""Decodes joysticks: report descriptors and reports of USB HID; opens no device."""
