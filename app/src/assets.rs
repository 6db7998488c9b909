//! The robots, objects and scenes that travel inside the program.
