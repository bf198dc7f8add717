"""Layers of pixels and text to cells, cells to terminal bytes."""
