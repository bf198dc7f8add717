"""Drawing on pixel canvases."""
