"""Parts that the drawing tools share: views, areas, labels, charts, the gallery's page."""
