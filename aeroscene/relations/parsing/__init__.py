"""Reading of relations off a scene's boxes: those that hold, rows and grids, tables with chairs."""
