"""What partitions decode to: the covers of sites, and the storeys of buildings."""
