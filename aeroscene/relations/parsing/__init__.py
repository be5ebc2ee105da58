"""From a scene's boxes to relations: which hold, rows and grids, tables with their chairs."""
