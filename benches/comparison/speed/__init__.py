"""How fast the equations of motion of a robot are, ours and others'."""
