"""Labels of one frame: normals, flow, masks, boxes and landing areas, from depth, ids and poses."""
