"""Links to a vehicle: UDP, TCP, serial ports."""
