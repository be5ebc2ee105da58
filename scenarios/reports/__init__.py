"""What campaigns have found, for people to read: pages, comparisons, a leaderboard."""
