"""Labelled images by the thousand: poses, labels, COCO, tar shards, and loaders for torch."""
