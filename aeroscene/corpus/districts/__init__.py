"""Districts: blocks along streets that meet, each filled by a program of its own."""
