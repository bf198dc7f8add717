"""The report of a study: one HTML page that stands alone, with pictures as SVG."""
