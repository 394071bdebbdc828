"""The scene around the person: room, objects, cameras, disturbances, and the compiled world."""
