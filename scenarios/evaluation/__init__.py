"""The tables of methods: scenes drawn by each, judged alike, told with intervals and pictures."""
