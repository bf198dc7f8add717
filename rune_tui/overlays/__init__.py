"""Pages and banners over the view."""
