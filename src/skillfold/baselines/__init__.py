"""What the papers compare with, and what a user would reach for otherwise."""
