"""What joysticks send, decoded: report descriptors and reports of USB HID; knows no device file."""
