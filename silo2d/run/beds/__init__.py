"""Acts of a discharge besides the opening of a door, and the bodies that rub and vibrate."""
