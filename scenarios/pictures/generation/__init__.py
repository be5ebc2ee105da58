"""Pictures of a scene while it is generated, from noise to the finished scene."""
