"""Episodes: where they take place, how they begin, and by what verdict they end."""
