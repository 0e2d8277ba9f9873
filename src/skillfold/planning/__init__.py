"""What planners of both families share: points to keep away from, and trees."""
