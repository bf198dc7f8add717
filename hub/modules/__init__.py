"""The robot's modules: one package per process, none imports another."""
