"""Pictures: the style of all figures, maps, and the pictures that the commands draw."""
