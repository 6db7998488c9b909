//! Who touches whom: robot with itself, with the scene, and with what it carries.
