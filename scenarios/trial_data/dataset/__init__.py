"""A dataset of many trials: tables in Parquet, images in tar shards, and a loader for torch."""
