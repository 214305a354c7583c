"""What a log tells of its wheels and its laser: bias, timing and noise."""
