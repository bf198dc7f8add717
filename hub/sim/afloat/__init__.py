"""Simulated bodies in a fluid: a blimp in air and an underwater robot; no bus, no hardware."""
