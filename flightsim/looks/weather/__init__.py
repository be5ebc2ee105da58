"""Time of day, weather and season of pictures: the words of users, the sun, and the light."""
